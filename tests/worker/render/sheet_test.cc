// Light through leaves: single open sheets between lights and viewers.
#include <gtest/gtest.h>

#include "tests/worker/render/radiance.h"
#include "worker/render/paths/scattering.h"

namespace parallax {
namespace {

using test::Build;
using test::Built;
using test::Estimate;
using test::MakeQuad;
using test::Radiance;
using test::TestScene;

// One quad of a leaf's size that is a sheet, or taken for the wall of a solid.
std::shared_ptr<const Mesh> Leaf(const Vec3f& corner, const Vec3f& u, const Vec3f& v,
                                 bool sheet = true) {
  auto mesh = std::make_shared<Mesh>(*MakeQuad(corner, u, v));
  mesh->slots[0].sheet = sheet;
  return mesh;
}

SurfaceSample LeafSample(const Vec3f& reflected, const Vec3f& transmitted) {
  SurfaceSample s = test::DiffuseSample(reflected);
  s.transmitted_color = transmitted;
  return s;
}

// A leaf at height 0, level; the sun stands `elevation` above the horizon, to the side of +x.
TestScene LeafInTheSun(const SurfaceSample& sample, double elevation, bool sheet = true) {
  TestScene test;
  test.AddMesh(Leaf({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, sheet), test.AddMaterial(sample));
  test.recipe.mutable_sky()->set_strength(1);
  test.recipe.mutable_sky()->set_sun_strength(1);
  test.recipe.mutable_sky()->set_sun_elevation_rad(elevation);
  return test;
}

// Under a sky that is alike on all sides a white sheet is as bright as the sky.
TEST(Sheets, VanishInAWhiteFurnace) {
  for (const float specular : {0.0f, 0.5f}) {
    TestScene test;
    SurfaceSample white = LeafSample(Vec3f::Constant(0.35f), Vec3f::Constant(0.65f));
    white.specular = specular;
    test.AddMesh(Leaf({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), test.AddMaterial(white));
    // A lamp all around: a sphere that shines inwards.
    SurfaceSample glow = test::DiffuseSample(Vec3f::Zero());
    glow.emission = Vec3f::Constant(3);
    auto dome = std::make_shared<Mesh>(*test::MakeSphere({0, 0, 0}, 20));
    test.AddMesh(dome, test.AddMaterial(glow));
    const Built built = Build(test);
    for (const float z : {0.7f, -0.7f}) {
      const Estimate seen = Radiance(built, {0.4f, 0.3f, z}, {0, 0, 0}, 4000, 2);
      EXPECT_NEAR(seen.mean.y(), 3.0f, 4 * seen.error + 0.03f) << specular << " from " << z;
    }
  }
}

// Closed form: sunlight of irradiance E leaves a dull leaf's far side with T E / pi.
TEST(Sheets, LitFromBehindShineWithWhatComesThrough) {
  const Vec3f reflected(0.1f, 0.2f, 0.05f), transmitted(0.2f, 0.3f, 0.02f);
  TestScene test = LeafInTheSun(LeafSample(reflected, transmitted), 1.1);
  test.recipe.mutable_sky()->set_strength(0.25);
  const Built built = Build(test);
  const SkyModel& sky = built.lights.sky();
  const Vec3f sun = sky.SunRadiance() * (sky.sun_solid_angle() * sky.sun_direction().z() * kInvPi);
  // The dome's light on both sides.
  Vec3f above = Vec3f::Zero(), below = Vec3f::Zero();
  constexpr int kSide = 400;
  for (int i = 0; i < kSide * kSide; ++i) {
    const float z = (static_cast<float>(i % kSide) + 0.5f) / kSide;
    const float a = 2 * kPi * (static_cast<float>(i / kSide) + 0.5f) / kSide;
    above += sky.Radiance(DirectionAt(z, a)) * (2.0f * z / (kSide * kSide));
    below += sky.Radiance(DirectionAt(-z, a)) * (2.0f * z / (kSide * kSide));
  }
  const Vec3f from_below = transmitted.cwiseProduct(sun + above) + reflected.cwiseProduct(below);
  const Vec3f from_above = reflected.cwiseProduct(sun + above) + transmitted.cwiseProduct(below);
  const Estimate under = Radiance(built, {0.1f, 0.2f, -1}, {0, 0, 0}, 20000, 1);
  const Estimate over = Radiance(built, {0.1f, 0.2f, 1}, {0, 0, 0}, 20000, 1);
  EXPECT_LT((under.mean - from_below).norm(), 0.02f * from_below.norm());
  EXPECT_LT((over.mean - from_above).norm(), 0.02f * from_above.norm());
  EXPECT_GT(Luminance(under.mean), 0.8f * Luminance(over.mean)) << "a leaf lit from behind is dark";
}

// The same material on the wall of a solid lets nothing through.
TEST(Sheets, OnlyOpenSheetsLetLightThrough) {
  const SurfaceSample leaf = LeafSample({0.1f, 0.2f, 0.05f}, {0.2f, 0.3f, 0.02f});
  const Built sheet = Build(LeafInTheSun(leaf, 1.1)), wall = Build(LeafInTheSun(leaf, 1.1, false));
  const Estimate through = Radiance(sheet, {0, 0, -1}, {0, 0, 0}, 3000, 1);
  const Estimate kept = Radiance(wall, {0, 0, -1}, {0, 0, 0}, 3000, 1);
  EXPECT_GT(through.mean.y(), 4 * kept.mean.y());
}

// Next-event estimation, sampling of the lobe, and both weighted find the same light from either
// side, whatever shines: sun, dome, lamps before and behind the leaf.
TEST(Sheets, EstimatorsOfDirectLightAgreeOnBothSides) {
  SurfaceSample leaf = LeafSample({0.1f, 0.2f, 0.05f}, {0.25f, 0.4f, 0.05f});
  leaf.specular = 0.5f;
  leaf.roughness = 0.5f;
  TestScene dome = LeafInTheSun(leaf, 0.9);
  dome.recipe.mutable_sky()->set_sun_strength(0);
  TestScene lamps;
  lamps.AddMesh(Leaf({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), lamps.AddMaterial(leaf));
  lamps.AddPointLight({0.6, 0.2, 1.1}, 0.3, 40);
  lamps.AddPointLight({-0.5, 0.3, -1.2}, 0.3, 25);
  lamps.AddMeshLight(lamps.AddMesh(MakeQuad({-0.5f, -0.5f, 1.9f}, {0, 1, 0}, {1, 0, 0}),
                                   lamps.AddMaterial(test::DiffuseSample(Vec3f::Zero()))),
                     60);
  for (const TestScene* test : {&dome, &lamps}) {
    const Built built = Build(*test);
    for (const float z : {0.8f, -0.8f}) {
      const Vec3f from(0.4f, -0.3f, z);
      const Estimate both = Radiance(built, from, {0, 0, 0}, 20000, 1);
      for (const DirectLight direct : {DirectLight::kLightSampling, DirectLight::kBsdfSampling}) {
        const Estimate one = Radiance(built, from, {0, 0, 0}, 60000, 1, direct);
        EXPECT_NEAR(Luminance(one.mean), Luminance(both.mean),
                    4 * (one.error + both.error) + 0.005f * Luminance(both.mean))
            << z << " " << static_cast<int>(direct) << (test == &dome ? " dome" : " lamps");
      }
      EXPECT_GT(Luminance(both.mean), 10 * both.error);
    }
  }
}

// Plants share their light with their likes; what furnishes a room keeps its own.
TEST(Sheets, LikePlantsAreOneGroupOfTheCache) {
  TestScene test;
  const uint32_t grey = test.AddMaterial(test::DiffuseSample(Vec3f::Constant(0.5f)));
  const auto leaf = Leaf({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
             other = Leaf({0, 0, 0}, {2, 0, 0}, {0, 1, 0});
  const auto chair = test::MakeBox({0, 0, 0}, {1, 1, 1}),
             stone = test::MakeBox({0, 0, 0}, {1, 2, 1});
  const auto place = [](int k) {
    return Eigen::Affine3f(Eigen::Translation3f(3.0f * static_cast<float>(k), 0, 0));
  };
  for (int k = 0; k < 2; ++k) {
    for (const auto& mesh : {leaf, other, chair}) test.AddMesh(mesh, grey, place(k));
  }
  for (int k = 0; k < 40; ++k) test.AddMesh(stone, grey, place(k));
  const auto scene = *RenderScene::Build(test.geometry, 0);
  const auto group = [&](uint32_t placed) { return scene->cache_group(placed).id; };
  EXPECT_EQ(group(0), group(3));
  EXPECT_EQ(group(1), group(4));
  EXPECT_NE(group(0), group(1));
  EXPECT_NE(group(2), group(5)) << "two chairs";
  EXPECT_EQ(group(6), group(45)) << "forty stones";
  EXPECT_GT(scene->cache_group(0).Coarse(0), 1.0f);
  EXPECT_EQ(scene->cache_group(2).Coarse(0), 1.0f);
}

// Relief or smooth normals lean away from the true one: what a leaf gives back stays below what it
// receives, and its halves are lit from behind as from before.
TEST(Sheets, LeaningNormalsKeepBothSidesAlike) {
  SurfaceInteraction8 at;
  at.position = Vec3x8::Zero();
  at.normal = Vec3x8(Vec3f::UnitZ());
  at.shading = Vec3x8(Vec3f(0.35f, 0, 1).normalized());
  at.out = Vec3x8(Vec3f(0.2f, 0.3f, 1).normalized());
  at.outside = ~Mask8{};
  at.surface.base_color = Vec3x8::All(Splat(0.3f));
  at.surface.transmitted_color = Vec3x8::All(Splat(0.3f));
  at.surface.specular = Splat(0);
  at.throughput = Vec3x8::All(Splat(1));
  at.spot_share = Splat(0);
  at.choice = at.u = at.v = Splat(0.5f);
  at.light.pdf = Splat(1);
  at.light.ideal = ~Mask8{};
  at.light.distance = Splat(kInfinity);
  at.light.radiance = Vec3x8::All(Splat(1));
  double above = 0, below = 0;
  constexpr int kSteps = 400;
  for (int i = 0; i < kSteps; ++i) {
    for (int k = 0; k < kSteps; k += kLanes) {
      for (int lane = 0; lane < kLanes; ++lane) {
        const float z = 2 * (static_cast<float>(i) + 0.5f) / kSteps - 1;
        at.light.direction.Set(lane,
                               DirectionAt(z, 2 * kPi * static_cast<float>(k + lane) / kSteps));
      }
      Shadow8 shadow;
      Scatter8(at).Light(true, &shadow);
      for (int lane = 0; lane < kLanes; ++lane) {
        if (shadow.lit[lane] == 0) continue;
        const double light = static_cast<double>(shadow.contribution.x[lane]);
        (at.light.direction.z[lane] > 0 ? above : below) += light;
        // Rays leave on the side where the light is.
        EXPECT_GT(shadow.origin.z[lane] * at.light.direction.z[lane], 0);
      }
    }
  }
  const double solid_angle = 4 * M_PI / (kSteps * kSteps);
  EXPECT_NEAR(above * solid_angle, 0.3, 0.02);
  EXPECT_NEAR(below * solid_angle, above * solid_angle, 1e-3);
}

}  // namespace
}  // namespace parallax
