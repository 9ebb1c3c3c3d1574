// Choosing lights by what they were seen to give.
#include "worker/render/lights/light_gains.h"

#include <gtest/gtest.h>

#include <set>

#include "common/base/rng.h"
#include "common/math/proto.h"
#include "tests/worker/render/radiance.h"
#include "worker/render/paths/cache_fill.h"
#include "worker/scene/types/indoor/house.h"

namespace parallax {
namespace {

using test::Build;
using test::Built;
using test::TestScene;

// A closed room of 4 x 2 x 2 m, cut in two by a wall at x = 2; in each half a lamp of its own.
TestScene TwoCells() {
  TestScene test;
  v1::Room* room = test.recipe.mutable_place()->mutable_house()->add_rooms();
  room->set_width_m(4);
  room->set_depth_m(2);
  room->set_height_m(2);
  test.geometry.surroundings = HouseSurroundings(test.recipe.place());
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
  return LightSampler(lights).Chance(test::Seek(lights, {x, 1.2f, 0}).at(), light);
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

// A point outside of all spots' cones under a dark sky has no light to choose.
TEST(LightGains, APointWithoutLightsTeachesNothing) {
  const Built built = Build(TwoCells());
  LightReceiver at;
  at.room = 0;
  at.total = 0;
  EXPECT_LT(TrialOf(built.lights, at, 0, 0, 0).room, 0);
  at.total = 1;
  const LightTrial trial = TrialOf(built.lights, at, 0, 0, 0);
  EXPECT_EQ(trial.room, 0);
  EXPECT_EQ(trial.gain, 0);
}

TEST(LightGains, AFillThatWasCancelledLeavesNothingToTheNext) {
  const CancelToken cancel;
  TestScene cells = TwoCells();
  const auto material = std::make_shared<test::CancellingMaterial>(cancel);
  cells.geometry.meshes[0].material_of_slot[0] = cells.AddMaterial(material);
  const std::vector<StereoCamera> rigs{
      *StereoCamera::FromRig(test::MakeRig({1, 0.2, 1}, {0, 1, -0.4}, 64, 48, 30, 0.1))};
  Built built = Build(cells);
  const auto fill = [&](const CancelToken& token) {
    return FillRadianceCache(*built.scene, &built.lights, {}, 1, rigs, Paths(20'000), token);
  };
  material->Arm(20'000);
  ASSERT_TRUE(absl::IsCancelled(fill(cancel).status()));
  ASSERT_LT(Chance(built.lights, 1.2f, 1), 0.3f);  // It has learnt from its first round.
  ASSERT_TRUE(fill({}).ok());
  const float after_another = Chance(built.lights, 1.2f, 1);
  built = Build(cells);
  ASSERT_TRUE(fill({}).ok());
  EXPECT_EQ(after_another, Chance(built.lights, 1.2f, 1));
}

// Whatever was learnt, right or wrong: chances that are told are those by which lights are chosen.
TEST(LightGains, EstimatesStayUnbiased) {
  const TestScene cells = TwoCells();
  Built built = Build(cells);
  const Vec3f floor(1.2f, 1.2f, 0);
  const LightReceiver before = test::Seek(built.lights, floor).at();
  std::vector<LightTrial> trials;
  for (int i = 0; i < 1000; ++i) {
    trials.push_back({0, before.cell, 0, 0.0f});  // A lie: this lamp does shine.
    trials.push_back({0, before.cell, 1, 1.0f});
  }
  LearnGains(std::vector<std::vector<LightTrial>>{trials}, &built.lights);
  const test::Estimate learnt = Radiance(built, {1.2f, 1.2f, 0.5f}, floor, 200'000, 1);
  const Built fresh = Build(cells);
  const test::Estimate wanted = Radiance(fresh, {1.2f, 1.2f, 0.5f}, floor, 50'000, 1);
  EXPECT_LT(Chance(built.lights, 1.2f, 0), 0.3f);
  EXPECT_NEAR(learnt.mean.y(), wanted.mean.y(), 4 * (learnt.error + wanted.error));
}

int32_t CellOf(const LightGains& gains, const Vec3f& position, const Vec3f& normal) {
  return gains.CellOf(Vec3x8(position), Vec3x8(normal))[0];
}

TEST(LightGains, CellsWithoutTrialsTakeTheRoomsWord) {
  LightGains gains(Box3f(Vec3f::Zero(), Vec3f(6, 6, 2)), 2);
  EXPECT_EQ(gains.Of(0, 1), 1.0f);
  const int32_t seen = CellOf(gains, {1, 1, 1}, Vec3f::UnitZ());
  for (int i = 0; i < 10'000; ++i) {
    gains.Add(seen, 0, 0.5f);
    gains.Add(seen, 1, 0.0f);
  }
  gains.Learn();
  for (const Vec3f& at : {Vec3f(1, 1, 1), Vec3f(5, 5, 1), Vec3f(-9, 99, 1)}) {
    const int32_t cell = CellOf(gains, at, Vec3f::UnitZ());
    EXPECT_NEAR(gains.Of(cell, 0), 0.5f, 1e-3f);
    EXPECT_FLOAT_EQ(gains.Of(cell, 1), LightGains::kLeast);
  }
}

// Every axis and sign is a way to face of its own, the longest component says which.
TEST(LightGains, SixWaysToFaceAreSixCells) {
  const LightGains gains(Box3f(Vec3f::Zero(), Vec3f(6, 6, 2)), 2);
  std::set<uint32_t> cells;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {-1.0f, 1.0f}) {
      Vec3f normal = Vec3f::Constant(0.3f);
      normal[axis] = 0.8f * sign;
      cells.insert(CellOf(gains, {1, 1, 1}, normal));
      EXPECT_EQ(CellOf(gains, {1, 1, 1}, normal), CellOf(gains, {1.1f, 1, 1.1f}, normal));
      EXPECT_NE(CellOf(gains, {1, 1, 1}, normal), CellOf(gains, {1, 1.6f, 1}, normal));
    }
  }
  EXPECT_EQ(cells.size(), 6u);
}

}  // namespace
}  // namespace parallax
