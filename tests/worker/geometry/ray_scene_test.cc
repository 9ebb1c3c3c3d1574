#include "worker/geometry/ray_scene.h"

#include <gtest/gtest.h>

#include "common/base/rng.h"
#include "tests/worker/geometry/shapes.h"

namespace parallax {
namespace {

using testing::BoxMesh;
using testing::TorusMesh;

Eigen::Affine3f At(const Vec3f& p) { return Eigen::Affine3f(Eigen::Translation3f(p)); }

TEST(RayScene, HitGivesDistanceBodyAndOutwardNormal) {
  RayScene scene;
  scene.Add(BoxMesh({0.5f, 0.5f, 0.5f}), At({5, 0, 0}));
  const uint32_t scaled =
      scene.Add(BoxMesh({0.5f, 0.5f, 0.5f}), At({-5, 0, 0}) * Eigen::Scaling(2.0f));
  scene.Commit();
  const auto hit = scene.Intersect({0, 0, 0.1f}, {-2, 0, 0});
  ASSERT_TRUE(hit.has_value());
  EXPECT_EQ(hit->body, scaled);
  EXPECT_NEAR(hit->distance, 2.0f, 1e-5f);
  EXPECT_TRUE(hit->normal.isApprox(Vec3f(1, 0, 0), 1e-5f));
  EXPECT_FALSE(scene.Intersect({0, 0, 0.1f}, {0, 1, 0}).has_value());
  EXPECT_FALSE(scene.Intersect({0, 0, 0.1f}, {-1, 0, 0}, 3.5f).has_value());
}

TEST(RayScene, OccludedSeesOnlyWhatStandsBetween) {
  RayScene scene;
  scene.Add(BoxMesh({0.5f, 0.5f, 0.5f}), At({2, 0, 0}));
  scene.Commit();
  EXPECT_TRUE(scene.Occluded({0, 0, 0}, {4, 0, 0}));
  EXPECT_FALSE(scene.Occluded({0, 0, 0}, {1.4f, 0, 0}));
  EXPECT_FALSE(scene.Occluded({0, 0, 0}, {1.5f, 0.1f, 0})) << "ends on the surface";
}

TEST(RayScene, DisabledBodiesAreNotSeen) {
  RayScene scene;
  const uint32_t box = scene.Add(BoxMesh({0.5f, 0.5f, 0.5f}), At({2, 0, 0}));
  scene.SetEnabled(box, false);
  scene.Commit();
  EXPECT_FALSE(scene.Intersect({0, 0, 0}, {1, 0, 0}).has_value());
  EXPECT_FALSE(scene.Overlaps(BoxMesh({0.5f, 0.5f, 0.5f}), At({2.1f, 0, 0})));
  EXPECT_FALSE(scene.Inside({2, 0, 0}));
  scene.SetEnabled(box, true);
  scene.Commit();
  EXPECT_TRUE(scene.Intersect({0, 0, 0}, {1, 0, 0}).has_value());
  EXPECT_TRUE(scene.Overlaps(BoxMesh({0.5f, 0.5f, 0.5f}), At({2.1f, 0, 0})));
  EXPECT_TRUE(scene.Inside({2, 0, 0}));
}

TEST(RayScene, NearestDistanceMatchesBruteForceUnderScaleAndTurn) {
  Rng rng(SceneSeed{3}, "nearest");
  RayScene scene;
  std::vector<std::array<Vec3f, 3>> all;
  for (int i = 0; i < 6; ++i) {
    const Mesh mesh = i % 2 ? BoxMesh({0.2f, 0.4f, 0.1f}) : TorusMesh(0.3f, 0.1f);
    Eigen::Affine3f place = Eigen::Affine3f::Identity();
    place.linear() = static_cast<float>(rng.Uniform(0.5, 2)) *
                     Eigen::AngleAxisf(static_cast<float>(rng.Uniform(0, 6)),
                                       Vec3f(1, static_cast<float>(i), 2).normalized())
                         .toRotationMatrix();
    place.translation() =
        Vec3d(rng.Uniform(-2, 2), rng.Uniform(-2, 2), rng.Uniform(-2, 2)).cast<float>();
    scene.Add(mesh, place);
    for (const Triangle& t : mesh.triangles) {
      all.push_back(
          {place * mesh.positions[t.a], place * mesh.positions[t.b], place * mesh.positions[t.c]});
    }
  }
  scene.Commit();
  for (int i = 0; i < 200; ++i) {
    const Vec3f p = Vec3d(rng.Uniform(-3, 3), rng.Uniform(-3, 3), rng.Uniform(-3, 3)).cast<float>();
    float best = 0.7f;
    for (const auto& t : all) best = std::min(best, PointTriangleDistance(p, t));
    EXPECT_NEAR(scene.NearestDistance(p, 0.7f), best, 1e-4f);
  }
}

TEST(RayScene, OverlapHoldsForOneWholeInsideTheOther) {
  RayScene scene;
  scene.Add(BoxMesh({1, 1, 1}), At({0, 0, 0}));
  scene.Commit();
  EXPECT_TRUE(scene.Overlaps(BoxMesh({0.1f, 0.1f, 0.1f}), At({0, 0, 0})));
  EXPECT_TRUE(scene.Overlaps(BoxMesh({3, 3, 3}), At({0, 0, 0})));
  EXPECT_FALSE(scene.Overlaps(BoxMesh({0.1f, 0.1f, 0.1f}), At({1.3f, 0, 0})));
}

}  // namespace
}  // namespace parallax
