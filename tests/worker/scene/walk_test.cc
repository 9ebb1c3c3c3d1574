#include "worker/scene/rigs/walk.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/config/config.h"
#include "worker/geometry/mesh.h"

namespace parallax {
namespace {

// A square of ground, `half_m` to each side, at a height.
Mesh SquareMesh(float half_m, float z) {
  Mesh mesh;
  mesh.positions = {
      {-half_m, -half_m, z}, {half_m, -half_m, z}, {half_m, half_m, z}, {-half_m, half_m, z}};
  mesh.triangles = {{0, 1, 2, 0}, {0, 2, 3, 0}};
  mesh.slots.push_back({"ground", {"soil"}, false});
  return mesh;
}

// Tries walks on a flat top with a valley `depth_m` below; returns the reasons why none succeeded.
std::map<std::string, int> ReasonsOnTop(float top_half_m, float depth_m) {
  v1::SceneConfig config = LoadSceneConfig("nature").value();
  config.mutable_rigs()->set_count(4);
  RayScene solid;
  solid.Add(SquareMesh(top_half_m, 0), Eigen::Affine3f::Identity());
  solid.Add(SquareMesh(30'000, -depth_m), Eigen::Affine3f::Identity());
  solid.Commit();
  const WalkLand land{[](const Vec2f&) { return 0.0f; }, solid, Vec2f::Zero(), 2};
  WalkFinder finder(config, 4);
  for (uint64_t seed = 0; seed < 40; ++seed) {
    const Rng rng(SceneSeed{seed}, "walk");
    const RigCamera camera = DrawRigCamera(config.rigs(), 0.5, rng);
    finder.Try(land, rng, camera);
  }
  return finder.reasons();
}

TEST(Walk, ViewsOfNothingButWhatIsFarBelowFail) {
  // From a pillar's top, all but the sky is kilometres away; on a plain, hardly anything is.
  EXPECT_GT(ReasonsOnTop(2, 1500)["distant"], 0);
  EXPECT_EQ(ReasonsOnTop(25'000, 1500)["distant"], 0);
}

}  // namespace
}  // namespace parallax
