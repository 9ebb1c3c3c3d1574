// A hit's data for shading, and that eight hits together give the data of each alone.
#include "worker/render/scene/render_scene.h"

#include <gtest/gtest.h>

#include "common/base/rng.h"
#include "tests/worker/render/test_scenes.h"
#include "worker/render/camera/camera_rays.h"

namespace parallax {
namespace {

using test::MakeQuad;
using test::TestScene;

// Its colour says where it is looked at; its relief rises along the texture's x.
class Ramp final : public PointMaterial {
 protected:
  SurfaceSample EvaluatePoint(const SurfacePoint& point) const override {
    SurfaceSample sample;
    sample.base_color = point.texture_m;
    sample.roughness = point.uv.x();
    sample.metallic = point.uv.y();
    sample.sheen = point.footprint_uv;
    sample.emission = point.texture_normal;
    sample.clearcoat = point.footprint_m;
    return sample;
  }
  float HeightOfPoint(const SurfacePoint& point) const override {
    return 0.1f * point.texture_m.x();
  }
};

struct Hit {
  RawHit raw;
  SurfaceId id;
  float footprint_m = 0;
};

HitBatch8 BatchOf(std::span<const Hit> hits) {
  HitBatch8 batch{};
  for (const Hit& hit : hits) batch.Add(hit.raw, hit.id, hit.footprint_m);
  return batch;
}

Hit Meet(const RenderScene& scene, const Vec3f& from, const Vec3f& to, float footprint_m) {
  Hit hit;
  Ray ray;
  ray.origin = from;
  ray.direction = (to - from).normalized();
  EXPECT_TRUE(scene.trees().Intersect(RayTrees::Tree::kFast, ray, 0, &hit.raw));
  hit.id = scene.Identify(hit.raw);
  hit.footprint_m = footprint_m;
  return hit;
}

// Two metres wide, turned to stand on the plane x = 1 and twice as large; uv over [0, 1]^2.
struct Wall {
  TestScene test;
  uint32_t material;
  std::unique_ptr<RenderScene> scene;

  Wall() {
    Mesh quad = *MakeQuad({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    for (size_t k = 0; k < quad.positions.size(); ++k) quad.uv[k] = quad.positions[k].head<2>();
    material = test.AddMaterial(std::make_shared<Ramp>());
    Eigen::Affine3f place = Eigen::Affine3f::Identity();
    place.linear().col(0) = Vec3f(0, 2, 0);
    place.linear().col(1) = Vec3f(0, 0, 2);
    place.linear().col(2) = Vec3f(2, 0, 0);
    place.translation() = Vec3f(1, 0, 0);
    test.AddMesh(std::make_shared<Mesh>(quad), material, place);
    scene = *RenderScene::Build(test.geometry, 0);
  }
};

TEST(RenderScene, AHitIsWhatTheMaterialSees) {
  const Wall wall;
  const Hit hit = Meet(*wall.scene, {3, 0.5f, 0.8f}, {1, 0.5f, 0.8f}, 0.01f);
  EXPECT_EQ(hit.id.material, wall.material);
  EXPECT_LT((hit.id.geometric_normal - Vec3f::UnitX()).norm(), 1e-6f);
  EXPECT_NEAR(hit.id.doubled_area, 4, 1e-5f);
  const SurfaceSample seen = wall.scene->Evaluate(hit.raw, hit.id, hit.footprint_m);
  EXPECT_LT((seen.base_color - Vec3f(0.5f, 0.8f, 0)).norm(), 1e-5f);  // Metres of the world.
  EXPECT_NEAR(seen.roughness, 0.25f, 1e-5f);
  EXPECT_NEAR(seen.metallic, 0.4f, 1e-5f);
  EXPECT_NEAR(seen.sheen, 0.005f, 1e-6f);  // One of uv is two metres.
  EXPECT_EQ(seen.clearcoat, 0.01f);
  EXPECT_LT((seen.emission - Vec3f::UnitZ()).norm(), 1e-5f);

  const MaterialSample8 look = wall.scene->EvaluateMaterial(BatchOf({{hit}}), hit.id.material);
  EXPECT_EQ(look.surface.Get(0).base_color, seen.base_color);
  // The texture's x runs along the world's y.
  EXPECT_LT((look.shading_normal.Get(0) - Vec3f(1, -0.1f, 0).normalized()).norm(), 1e-3f);
  const Vec3f smooth = wall.scene->Interpolate(BatchOf({{hit}})).shading_normal.Get(0);
  EXPECT_LT((smooth - Vec3f::UnitX()).norm(), 1e-6f);
}

TEST(RenderScene, EightHitsAreLookedAtAsEachAlone) {
  TestScene test;
  const uint32_t ramp = test.AddMaterial(std::make_shared<Ramp>());
  const auto ball = test::MakeSphere({0, 0, 0}, 1, 12);
  for (int k = 0; k < 3; ++k) {
    Eigen::Affine3f place = Eigen::Affine3f::Identity();
    place.translation() = Vec3f(3.0f * static_cast<float>(k), 0, 0);
    place.rotate(Eigen::AngleAxisf(static_cast<float>(k), Vec3f(1, 2, 3).normalized()));
    place.scale(1 + 0.1f * static_cast<float>(k));
    test.AddMesh(ball, ramp, place);
  }
  // Tests the scene without instances, with nothing else, and with some.
  for (const int every : {0, 1, 2}) {
    const auto scene = *RenderScene::Build(test.geometry, 0, test::MoversOfEvery(every, test));
    Rng rng(SceneSeed{2}, "hits");
    const auto draw = [&](double low, double high) {
      return static_cast<float>(rng.Uniform(low, high));
    };
    for (int round = 0; round < 24; ++round) {
      std::vector<Hit> hits;
      for (int k = 0; k <= round % kLanes; ++k) {
        const Vec3f center(3.0f * static_cast<float>(k % 3), 0, 0);
        const Vec3f from = center + Vec3f(draw(-1, 1), draw(-1, 1), 4);
        hits.push_back(Meet(*scene, from, center + Vec3f(0, draw(-0.5, 0.5), 0), draw(0, 0.02)));
      }
      const MaterialSample8 together = scene->EvaluateMaterial(BatchOf(hits), ramp);
      for (size_t k = 0; k < hits.size(); ++k) {
        const MaterialSample8 alone = scene->EvaluateMaterial(BatchOf({{hits[k]}}), ramp);
        const int lane = static_cast<int>(k);
        EXPECT_EQ(together.shading_normal.Get(lane), alone.shading_normal.Get(0)) << k;
        const SurfaceSample a = together.surface.Get(lane), b = alone.surface.Get(0);
        EXPECT_EQ(a.base_color, b.base_color);
        EXPECT_EQ(a.emission, b.emission);
        EXPECT_EQ(Vec3f(a.roughness, a.metallic, a.sheen), Vec3f(b.roughness, b.metallic, b.sheen));
        EXPECT_EQ(a.clearcoat, hits[k].footprint_m);
        EXPECT_GT(alone.shading_normal.Get(0).dot(hits[k].id.geometric_normal), 0.0f);
        EXPECT_NEAR(alone.shading_normal.Get(0).norm(), 1.0f, 1e-5f);
      }
    }
  }
}

TEST(RenderScene, NormalsThatCancelAreThoseOfACornerOrTheFace) {
  Mesh quad = *MakeQuad({0, 0, 0}, {2, 0, 0}, {0, 2, 0});
  for (size_t k = 0; k < quad.normals.size(); ++k) {
    quad.normals[k] = Vec3f(quad.positions[k].x() > 1 ? 1 : -1, 0, 0);
  }
  TestScene test;
  test.AddMesh(std::make_shared<Mesh>(quad), 0);
  const auto scene = *RenderScene::Build(test.geometry, 0);
  const Hit hit = Meet(*scene, {1, 0.5f, 1}, {1, 0.5f, 0}, 0);
  const Interpolated8 at = scene->Interpolate(BatchOf({{hit}}));
  EXPECT_EQ(at.shading_normal.Get(0), Vec3f::UnitZ());
  EXPECT_EQ(std::abs(at.points.normal.x[0]), 1.0f);
}

TEST(CameraRays, EightAreThoseOfEachAlone) {
  const CameraRays rays(
      StereoCamera::FromRig(test::MakeRig({1, 2, 3}, {1, 0.4, -0.2}, 64, 48, 50, 0.1))->eyes[0]);
  Float8 x, y;
  for (int k = 0; k < kLanes; ++k) {
    x[k] = 7.3f * static_cast<float>(k);
    y[k] = 41.0f - 5.1f * static_cast<float>(k);
  }
  const Rays8 eight = rays.Through(x, y);
  for (int k = 0; k < kLanes; ++k) {
    const Ray one = rays.Through(x[k], y[k]);
    EXPECT_EQ(eight.direction.Get(k), one.direction);
    EXPECT_EQ(eight.origin.Get(k), one.origin);
    EXPECT_EQ(rays.spread(), one.spread);
  }
}

// Cases: all eight hits on one body, on several bodies, and some rays without a hit.
TEST(RenderScene, EightHitsAreNamedAsEachAlone) {
  TestScene test;
  const auto ball = test::MakeSphere({0, 0, 0}, 1, 12);
  for (int k = 0; k < 3; ++k) {
    Eigen::Affine3f place = Eigen::Affine3f::Identity();
    place.translation() = Vec3f(3.0f * static_cast<float>(k), 0, 0);
    place.scale(1 + 0.1f * static_cast<float>(k));
    test.AddMesh(ball, test.AddMaterial(std::make_shared<Ramp>()), place);
  }
  for (const int every : {0, 1, 2}) {
    const auto scene = *RenderScene::Build(test.geometry, 0, test::MoversOfEvery(every, test));
    for (int round = 0; round < 8; ++round) {
      Rays8 rays{Vec3x8::Zero(), Vec3x8(Vec3f(0, 0, -1))};
      for (int lane = 0; lane < kLanes; ++lane) {
        const int body = round < 4 ? 1 : lane % 4;  // Behind the last ball there is nothing.
        rays.origin.Set(lane, {3.0f * static_cast<float>(body) + 0.1f * static_cast<float>(lane),
                               0.05f * static_cast<float>(round), 4});
      }
      Hits8 hits;
      scene->trees().Intersect(RayTrees::Tree::kFast, rays, ~Mask8{}, false, &hits);
      const SurfaceIds8 ids = scene->Identify(hits);
      for (int lane = 0; lane < kLanes; ++lane) {
        ASSERT_EQ(hits.met[lane] != 0, round < 4 || lane % 4 < 3);
        if (hits.met[lane] == 0) continue;
        const SurfaceId alone = scene->Identify(hits.Get(lane));
        EXPECT_EQ(ids.geometric_normal.Get(lane), alone.geometric_normal);
        EXPECT_EQ(ids.doubled_area[lane], alone.doubled_area);
        EXPECT_EQ(ids.slot[lane], alone.slot);
        EXPECT_EQ(static_cast<uint32_t>(ids.material[lane]), alone.material);
      }
    }
  }
}

}  // namespace
}  // namespace parallax
