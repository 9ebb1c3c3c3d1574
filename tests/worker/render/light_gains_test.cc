// Choosing lights by what they were seen to give.
#include "worker/render/light_gains.h"

#include <gtest/gtest.h>

#include "common/base/rng.h"
#include "common/math/proto.h"
#include "tests/worker/render/radiance.h"
#include "worker/render/cache_fill.h"

namespace parallax {
namespace {

using test::Build;
using test::Built;
using test::TestScene;

// A closed room of 4 x 2 x 2 m, cut in two by a wall at x = 2; in each half a lamp of its own.
TestScene TwoCells() {
  TestScene test;
  v1::Room* room = test.recipe.mutable_room();
  room->set_width_m(4);
  room->set_depth_m(2);
  room->set_height_m(2);
  const uint32_t grey = test.AddMaterial(test::DiffuseSample(Vec3f::Constant(0.5f)));
  test.AddMesh(test::MakeBox({0, 0, 0}, {4, 2, 2}, true), grey);
  test.AddMesh(test::MakeBox({1.98f, 0, 0}, {2.02f, 2, 2}), grey);
  test.AddPointLight({1, 1, 1.8}, 0.02, 50);
  test.AddPointLight({3, 1, 1.8}, 0.02, 50);
  return test;
}

CacheFill Paths(int64_t paths) {
  CacheFill fill;
  fill.paths = paths;
  return fill;
}

// Chance that the lamp at `light` is chosen from the floor of the half at `x`.
float Chance(const LightTable& lights, float x, size_t light) {
  LightImportances importances;
  const LightReceiver at = lights.Receive({x, 1.2f, 0}, Vec3f::UnitZ(), &importances);
  return importances[light] / at.total;
}

TEST(LightGains, LampsBehindAWallAreSeldomChosen) {
  Built built = Build(TwoCells());
  EXPECT_GT(Chance(built.lights, 1.2f, 1), 0.3f);
  std::vector<StereoCamera> rigs;
  for (const double x : {1.0, 3.0}) {
    rigs.push_back(
        *StereoCamera::FromRig(test::MakeRig({x, 0.2, 1}, {0, 1, -0.4}, 64, 48, 30, 0.1)));
  }
  ASSERT_TRUE(FillRadianceCache(*built.scene, &built.lights, {}, 1, rigs, Paths(100'000), {}).ok());
  for (const float x : {1.2f, 2.8f}) {
    const size_t hidden = x < 2 ? 1 : 0;
    EXPECT_LT(Chance(built.lights, x, hidden), 0.1f) << x;
    EXPECT_GT(Chance(built.lights, x, hidden), 0.0f) << x;
  }
}

// Whatever was learnt, right or wrong: chances that are told are those by which lights are chosen.
TEST(LightGains, EstimatesStayUnbiased) {
  TestScene test = TwoCells();
  Built built = Build(test);
  LightImportances importances;
  const Vec3f floor(1.2f, 1.2f, 0);
  const LightReceiver before = built.lights.Receive(floor, Vec3f::UnitZ(), &importances);
  std::vector<LightTrial> trials;
  for (int i = 0; i < 1000; ++i) {
    trials.push_back({0, before.cell, 0, 0.0f});  // A lie: this lamp does shine.
    trials.push_back({0, before.cell, 1, 1.0f});
  }
  built.lights.Learn(std::vector<std::vector<LightTrial>>{trials});
  const test::Estimate learnt = Radiance(built, {1.2f, 1.2f, 0.5f}, floor, 200'000, 1);
  const Built fresh = Build(test);
  const test::Estimate wanted = Radiance(fresh, {1.2f, 1.2f, 0.5f}, floor, 50'000, 1);
  EXPECT_LT(Chance(built.lights, 1.2f, 0), 0.3f);
  EXPECT_NEAR(learnt.mean.y(), wanted.mean.y(), 4 * (learnt.error + wanted.error));
}

TEST(LightGains, CellsWithoutTrialsTakeTheRoomsWord) {
  LightGains gains(Box3f(Vec3f::Zero(), Vec3f(6, 6, 2)), 2);
  EXPECT_EQ(gains.Of(0), nullptr);
  const uint32_t seen = gains.CellOf({1, 1, 1}, Vec3f::UnitZ());
  for (int i = 0; i < 10'000; ++i) {
    gains.Add(seen, 0, 0.5f);
    gains.Add(seen, 1, 0.0f);
  }
  gains.Learn();
  for (const Vec3f& at : {Vec3f(1, 1, 1), Vec3f(5, 5, 1), Vec3f(-9, 99, 1)}) {
    const float* of = gains.Of(gains.CellOf(at, Vec3f::UnitZ()));
    EXPECT_NEAR(of[0], 0.5f, 1e-3f);
    EXPECT_FLOAT_EQ(of[1], LightGains::kLeast);
  }
  EXPECT_NE(seen, gains.CellOf({1, 1, 1}, -Vec3f::UnitZ()));
}

}  // namespace
}  // namespace parallax
