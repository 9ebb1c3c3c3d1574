#include "worker/render/raster/rasteriser.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>

#include "common/config/config.h"
#include "tests/worker/render/radiance.h"
#include "tests/worker/render/raster/agreement.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/solve_scene.h"

namespace parallax {
namespace {

using test::Agreement;
using test::MakeBox;
using test::MakeQuad;
using test::TestScene;

constexpr int kSamples = VisibilityBuffer::kSamples;

// Looks along +y from `origin`, 90 degrees wide.
StereoCamera Looking(const Vec3d& origin, int width = 96, int height = 64) {
  return *StereoCamera::FromRig(test::MakeRig(origin, {0, 1, 0}, width, height, 0.5 * width, 0.06));
}

VisibilityBuffer Drawn(const RenderScene& scene, const PinholeCamera& camera, uint32_t stream = 7) {
  return Rasteriser::Create(scene)->Draw(camera, stream, {});
}

// Number of samples that see each body; the last: nothing.
std::vector<int> SamplesOfBodies(const RenderScene& scene, const VisibilityBuffer& visible) {
  std::vector<int> seen(scene.body_count() + 1);
  for (int y = 0; y < visible.height(); ++y) {
    for (int x = 0; x < visible.width(); ++x) {
      for (int k = 0; k < kSamples; ++k) {
        const uint32_t id = visible.Ids(x, y)[k];
        ++seen[id == VisibilityBuffer::kNothing ? scene.body_count() : visible.TriangleOf(id).body];
      }
    }
  }
  return seen;
}

bool Same(const VisibilityBuffer& a, const VisibilityBuffer& b) {
  return std::equal(a.Ids(0, 0), a.Ids(0, 0) + size_t{1} * a.width() * a.height() * kSamples,
                    b.Ids(0, 0));
}

void ExpectAgreement(const Agreement& sum) {
  EXPECT_GE(sum.agreeing(), 0.995);
  EXPECT_LE(sum.missed, 1e-4 * sum.samples);
  EXPECT_LE(sum.invented, 1e-3 * sum.samples);
}

TEST(Rasteriser, SeesTheTrianglesThatRaysMeet) {
  for (const int every : {0, 1, 2}) {
    const TestScene test = test::MakeBoxRoom();
    const auto scene = *RenderScene::Build(test.geometry, 0, test::MoversOfEvery(every, test));
    Rng rng(SceneSeed{1}, "samples");
    Agreement sum;
    for (int i = 0; i < 8; ++i) {
      const Vec3d at(0.4 + 0.42 * i, 0.4 + 0.12 * i, 0.9 + 0.1 * i);
      const Vec3d ahead(std::sin(0.8 * i), std::cos(0.8 * i), 0.05 * i - 0.3);
      const auto stereo = *StereoCamera::FromRig(test::MakeRig(at, ahead, 160, 90, 90, 0.1));
      for (const PinholeCamera& eye : stereo.eyes) {
        Compare(*scene, eye, Drawn(*scene, eye), 1500, rng, &sum);
      }
    }
    ExpectAgreement(sum);
    EXPECT_GE(sum.same_triangle, 0.995 * sum.samples);
  }
}

TEST(Rasteriser, DrawsWhatMovesWhereItIs) {
  TestScene test;
  test.AddMesh(MakeQuad({-9, 9, -9}, {18, 0, 0}, {0, 0, 18}), 0);
  test.AddMesh(MakeBox({-0.5f, 2, -0.5f}, {0.5f, 3, 0.5f}), 0);
  const auto scene = *RenderScene::Build(test.geometry, 0, {false, true});
  const auto rasteriser = *Rasteriser::Create(*scene);
  Rng rng(SceneSeed{2}, "samples");
  const PinholeCamera eye = Looking({0, 0, 0}).eyes[0];
  const auto before = SamplesOfBodies(*scene, rasteriser.Draw(eye, 1, {}));
  std::vector<Eigen::Affine3f> places(2, Eigen::Affine3f::Identity());
  places[1] = Eigen::Translation3f(0, 2, 0) * Eigen::AngleAxisf(0.3f, Vec3f::UnitZ());
  ASSERT_TRUE(scene->Move(places).ok());
  const VisibilityBuffer visible = rasteriser.Draw(eye, 1, {});
  EXPECT_LT(SamplesOfBodies(*scene, visible)[1], before[1] / 2);
  Agreement sum;
  Compare(*scene, eye, visible, 1500, rng, &sum);
  ExpectAgreement(sum);
}

TEST(Rasteriser, ResultDoesNotDependOnThreads) {
  const TestScene test = test::MakeBoxRoom();
  const auto scene = *RenderScene::Build(test.geometry, 0);
  // Five strips.
  const PinholeCamera eye = StereoCamera::FromRig(test::BoxRoomRig(300, 300))->eyes[1];
  const auto with = [&](size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return Drawn(*scene, eye);
  };
  const VisibilityBuffer one = with(1);
  EXPECT_TRUE(Same(one, with(2)));
  EXPECT_TRUE(Same(one, with(4)));
  EXPECT_FALSE(Same(one, Drawn(*scene, eye, 8)));  // Another stream has other points.
}

// The second body is drawn first: it has a triangle that is nearer.
TEST(Rasteriser, OfEquallyNearTrianglesTheLowerBodyIsSeen) {
  for (const size_t nearer : {0u, 1u}) {
    TestScene test;
    const auto wall = MakeQuad({-1, 3, -1}, {2, 0, 0.3f}, {0, 0.2f, 2});
    auto both = std::make_shared<Mesh>(*wall);
    Append(*both, *MakeQuad({-3, 1, 2}, {0.1f, 0, 0}, {0, 0, 0.1f}));
    for (const size_t i : {0u, 1u}) test.AddMesh(i == nearer ? both : wall, 0);
    const auto scene = *RenderScene::Build(test.geometry, 0);
    const std::vector<int> seen =
        SamplesOfBodies(*scene, Drawn(*scene, Looking({0, 0, 0}).eyes[0]));
    EXPECT_GT(seen[0], 1000) << nearer;
    EXPECT_EQ(seen[1], 0) << nearer;
  }
}

TEST(Rasteriser, SheetsAndClosedBodiesAreSeenFromBothSides) {
  for (const bool inwards : {false, true}) {
    TestScene test;
    test.AddMesh(MakeBox({-2, -2, -2}, {2, 2, 2}, inwards), 0);
    test.AddMesh(MakeQuad({-0.3f, 1, -0.3f}, {0.6f, 0, 0}, {0, 0, 0.6f}), 0);
    test.AddMesh(MakeQuad({-1.3f, 1, -0.3f}, {0, 0, 0.6f}, {0.6f, 0, 0}), 0);
    const auto scene = *RenderScene::Build(test.geometry, 0);
    const std::vector<int> seen =
        SamplesOfBodies(*scene, Drawn(*scene, Looking({0, 0, 0}).eyes[0]));
    EXPECT_GT(seen[1], 1000);
    EXPECT_GT(seen[2], 1000);
    EXPECT_EQ(seen[3], 0);
  }
}

// A floor and a wall that pass the eye within centimetres, and reach far behind it.
TEST(Rasteriser, WhatPassesTheEyeIsCutAtTheNearPlane) {
  TestScene test;
  test.AddMesh(MakeQuad({-50, -50, -0.03f}, {100, 0, 0}, {0, 100, 0}), 0);
  test.AddMesh(MakeQuad({0.05f, -40, -50}, {0.4f, 90, 0}, {0, 0, 100}), 0);
  test.AddMesh(test::MakeSphere({-0.4f, 0.1f, 0.2f}, 0.39f), 0);
  const auto scene = *RenderScene::Build(test.geometry, 0);
  const PinholeCamera eye = Looking({0, 0, 0}).eyes[0];
  Rng rng(SceneSeed{3}, "samples");
  Agreement sum;
  Compare(*scene, eye, Drawn(*scene, eye), 20'000, rng, &sum);
  ExpectAgreement(sum);
  EXPECT_EQ(sum.missed, 0);
  EXPECT_EQ(sum.invented, 0);
}

// Quads whose common edges run exactly through the samples of a pixel.
TEST(Rasteriser, NoSampleFallsBetweenTrianglesThatShareAnEdge) {
  PinholeCamera eye;  // Projects numbers of 24 bits without rounding.
  eye.fx_px = eye.fy_px = 64;
  eye.width_px = eye.height_px = 32;
  const SamplePoints points(7);
  const int x = 5, y = 9;
  std::vector<float> edges(points.X(x, y), points.X(x, y) + kSamples);
  std::sort(edges.begin(), edges.end());
  for (float& edge : edges) edge = (edge + x) / 64;
  edges.insert(edges.begin(), 0.0f);
  edges.push_back(0.5f);
  auto mesh = std::make_shared<Mesh>();
  for (size_t i = 0; i + 1 < edges.size(); ++i) {
    Append(*mesh, *MakeQuad({edges[i], 0, 1}, {edges[i + 1] - edges[i], 0, 0}, {0, 0.5f, 0}));
  }
  TestScene test;
  test.AddMesh(mesh, 0);
  const auto scene = *RenderScene::Build(test.geometry, 0);
  EXPECT_EQ(SamplesOfBodies(*scene, Drawn(*scene, eye))[1], 0);
}

TEST(Rasteriser, AClosedBallHasNoHoles) {
  TestScene test;
  test.AddMesh(test::MakeSphere({0, 0, 0}, 3, 200), 0);
  const auto scene = *RenderScene::Build(test.geometry, 0);
  for (const Vec3d& at : {Vec3d(0, 0, 0), Vec3d(0.3, 2.9, 0.1), Vec3d(-1, -2, 1)}) {
    const PinholeCamera eye = Looking(at, 256, 160).eyes[0];
    EXPECT_EQ(SamplesOfBodies(*scene, Drawn(*scene, eye))[1], 0);
  }
}

// Known hits are those of the rays, also on bodies that are instances.
TEST(RenderScene, HitsOnKnownTrianglesAreThoseOfRays) {
  for (const int every : {0, 1}) {
    const TestScene test = test::MakeBoxRoom();
    const auto scene = *RenderScene::Build(test.geometry, 0, test::MoversOfEvery(every, test));
    Rng rng(SceneSeed{4}, "rays");
    for (int i = 0; i < 500; ++i) {
      Rays8 rays{Vec3x8(Vec3f(0.5f, 0.2f, 1.4f)), Vec3x8::Zero()};
      for (int k = 0; k < kLanes; ++k) {
        rays.direction.Set(k,
                           Vec3f(static_cast<float>(rng.Normal()), static_cast<float>(rng.Normal()),
                                 static_cast<float>(rng.Normal()))
                               .normalized());
      }
      Hits8 wanted;
      scene->trees().Intersect(RayTrees::Tree::kRobust, rays, ~Mask8{}, false, &wanted);
      Hits8 hits;
      hits.met = wanted.met;
      hits.placed = wanted.placed;
      hits.triangle = wanted.triangle;
      scene->HitTriangles(rays, &hits);
      for (int k = 0; k < kLanes; ++k) {
        const RawHit a = hits.Get(k), b = wanted.Get(k);
        EXPECT_NEAR(a.distance, b.distance, 1e-5f);
        EXPECT_NEAR(a.u, b.u, 2e-4f);
        EXPECT_NEAR(a.v, b.v, 2e-4f);
        EXPECT_NEAR((a.position - b.position).norm(), 0, 1e-5f);
        EXPECT_NEAR((a.edge_cross - b.edge_cross).norm(), 0, 1e-5f);
      }
    }
  }
}

// Small pictures of a landscape of one biome, or of a room.
v1::SceneConfig Pictures(const std::string& biome) {
  v1::SceneConfig config = *LoadSceneConfig(biome.empty() ? "indoor" : "nature");
  v1::BiomeWeights& weights = *config.mutable_nature()->mutable_biomes();
  const auto* fields = weights.GetDescriptor();
  for (int k = 0; k < fields->field_count() && !biome.empty(); ++k) {
    weights.GetReflection()->SetDouble(&weights, fields->field(k),
                                       fields->field(k)->name() == biome);
  }
  config.mutable_rigs()->set_count(2);
  config.mutable_rigs()->set_width_px(320);
  config.mutable_rigs()->set_height_px(180);
  return config;
}

TEST(Rasteriser, SeesWhatRaysMeetInRoomsAndLandscapes) {
  for (const std::string biome : {"", "forest", "plain", "mountain"}) {
    SCOPED_TRACE(biome);
    v1::SolveJob job;
    job.set_scene_seed(7002);
    *job.mutable_config() = Pictures(biome);
    const auto solved = Solve(job, {});
    ASSERT_TRUE(solved.ok() && solved->has_scene());
    const auto scene = *RenderScene::Build(*BuildSceneGeometry(solved->scene()), 0);
    const auto rasteriser = *Rasteriser::Create(*scene);
    Rng rng(SceneSeed{5}, "samples");
    Agreement sum;
    for (const v1::Rig& rig : solved->scene().rigs()) {
      const StereoCamera stereo = *StereoCamera::FromRig(rig);
      for (const PinholeCamera& eye : stereo.eyes) {
        Compare(*scene, eye, rasteriser.Draw(eye, 11, {}), 3000, rng, &sum);
      }
    }
    ExpectAgreement(sum);
  }
}

}  // namespace
}  // namespace parallax
