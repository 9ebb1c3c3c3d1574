// Paths that leave towards the places that were seen to be bright.
#include "worker/render/lights/bright_spots.h"

#include <gtest/gtest.h>

#include <array>

#include "common/base/rng.h"
#include "common/math/proto.h"
#include "tests/worker/render/radiance.h"
#include "worker/render/paths/cache_fill.h"
#include "worker/render/surface/sampling.h"
#include "worker/scene/types/indoor/house.h"

namespace parallax {
namespace {

using test::Build;
using test::Built;
using test::TestScene;

// A closed room of 4 x 4 x 2.5 m with a lamp right below its ceiling, above a plate: the floor gets
// all of its light from the small bright patch of ceiling.
TestScene LampAboveAPlate() {
  TestScene test;
  v1::Room* room = test.recipe.mutable_place()->mutable_house()->add_rooms();
  room->set_width_m(4);
  room->set_depth_m(4);
  room->set_height_m(2.5);
  test.geometry.surroundings = HouseSurroundings(test.recipe.place());
  const uint32_t grey = test.AddMaterial(test::DiffuseSample(Vec3f::Constant(0.5f)));
  test.AddMesh(test::MakeBox({0, 0, 0}, {4, 4, 2.5f}, true), grey);
  test.AddMesh(test::MakeBox({1.8f, 1.8f, 2.28f}, {2.2f, 2.2f, 2.3f}), grey);
  test.AddPointLight({2, 2, 2.42}, 0.01, 50);
  return test;
}

// Bright and less bright: a patch overhead, one on a wall, one behind the surface.
BrightSpots ThreeSpots() {
  BrightSpots spots;
  for (int i = 0; i < 10; ++i) {
    spots.Add({1.05f, 1.05f, 2.5f}, -Vec3f::UnitZ(), 40);
    spots.Add({4, 2, 1}, -Vec3f::UnitX(), 20);
    spots.Add({2, 2, -1}, Vec3f::UnitZ(), 90);
  }
  for (int x = 0; x < 100; ++x) {
    for (int i = 0; i < 5; ++i) spots.Add({0.3f * static_cast<float>(x), 9, 0}, Vec3f::UnitY(), 1);
  }
  spots.Learn();
  return spots;
}

TEST(BrightSpots, DensityIsThatOfSampling) {
  const BrightSpots spots = ThreeSpots();
  const SpotView view(spots, {2, 1, 0}, Vec3f::UnitZ());
  ASSERT_GT(view.share(), 0.0f);
  Rng rng(SceneSeed{1}, "bright_spots_test");
  const auto uniform = [&] { return static_cast<float>(rng.Uniform()); };
  constexpr int kSamples = 400'000;
  // By halves of the sphere, cut so that each spot is on a side of its own.
  const auto part = [](const Vec3f& d) { return static_cast<size_t>(d.x() > 0.3f ? 1 : 0); };
  std::array<double, 2> chosen{}, promised{};
  for (int i = 0; i < kSamples; ++i) {
    const Vec3f sampled = view.Sample(uniform(), {uniform(), uniform()});
    ASSERT_NEAR(sampled.norm(), 1.0f, 1e-4f);
    ASSERT_GT(view.Pdf(sampled), 0.0f);
    chosen[part(sampled)] += 1.0 / kSamples;
  }
  constexpr int kHeights = 1500, kTurns = 3000;  // Cells of equal solid angle.
  for (int h = 0; h < kHeights; ++h) {
    for (int t = 0; t < kTurns; ++t) {
      const Vec3f d = DirectionAt((static_cast<float>(h) + 0.5f) * (2.0f / kHeights) - 1,
                                  (static_cast<float>(t) + 0.5f) * (2 * kPi / kTurns));
      promised[part(d)] += view.Pdf(d) * 4 * kPi / (kHeights * kTurns);
    }
  }
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_GT(chosen[i], 0.02) << i;
    EXPECT_NEAR(chosen[i], promised[i], 0.01) << i;
  }
}

TEST(BrightSpots, OnlyWhatFacesTheSurfaceIsLookedAt) {
  const BrightSpots spots = ThreeSpots();
  const SpotView view(spots, {2, 1, 0}, Vec3f::UnitZ());
  EXPECT_GT(view.Pdf(Vec3f(-0.95f, 0.05f, 2.5f).normalized()), 0.0f);
  EXPECT_EQ(view.Pdf(Vec3f(0, 1, -1).normalized()), 0.0f);  // The brightest, below the floor.
  EXPECT_EQ(view.Pdf(Vec3f(-1, -1, 0.1f).normalized()), 0.0f);
  EXPECT_LT(view.share(), 1.0f);
}

TEST(BrightSpots, WithoutLightThereIsNoShare) {
  BrightSpots spots;
  EXPECT_EQ(SpotView(spots, Vec3f::Zero(), Vec3f::UnitZ()).share(), 0.0f);
  for (int i = 0; i < 10; ++i) spots.Add({1, 1, 2.5f}, -Vec3f::UnitZ(), 0);
  spots.Learn();
  EXPECT_EQ(SpotView(spots, Vec3f::Zero(), Vec3f::UnitZ()).share(), 0.0f);
}

// Few rooms have spots that are worth the time.
TEST(BrightSpots, ARoomThatIsLitEvenlyDoesWithout) {
  const auto share = [](float brightest) {
    BrightSpots spots;
    for (int x = 0; x < 400; ++x) {
      const float radiance = x == 0 ? brightest : 1.0f;
      for (int i = 0; i < 5; ++i) {
        spots.Add({0.15f + 0.3f * static_cast<float>(x % 20),
                   0.15f + 0.3f * static_cast<float>(x / 20), 2.5f},
                  -Vec3f::UnitZ(), radiance);
      }
    }
    spots.Learn();
    return SpotView(spots, {1, 1, 1}, Vec3f::UnitZ()).share();
  };
  EXPECT_EQ(share(10), 0.0f);
  EXPECT_GT(share(60), 0.0f);
}

// Whatever was learnt, right or wrong.
TEST(BrightSpots, EstimatesStayUnbiased) {
  const TestScene test = LampAboveAPlate();
  Built built = Build(test);
  std::vector<LightSeen> seen;
  for (int i = 0; i < 10; ++i) {
    seen.push_back({{0.1f, 3.9f, 2.5f}, -Vec3f::UnitZ(), 50});  // A lie.
    seen.push_back({{2, 2, 2.5f}, -Vec3f::UnitZ(), 50});
    seen.push_back({{3.9f, 3.9f, 0}, Vec3f::UnitZ(), 0.1f});
  }
  LearnSpots(std::vector<std::vector<LightSeen>>{seen}, &built.lights);
  const Vec3f from(1, 1, 0.5f), floor(1, 1, 0);
  const test::Estimate learnt = Radiance(built, from, floor, 300'000, 3);
  const test::Estimate wanted = Radiance(Build(test), from, floor, 600'000, 3);
  EXPECT_LT(learnt.error, 0.03f * learnt.mean.y());
  EXPECT_NEAR(learnt.mean.y(), wanted.mean.y(), 4 * (learnt.error + wanted.error));
}

TEST(BrightSpots, LightFromASmallPatchIsFound) {
  const TestScene test = LampAboveAPlate();
  Built built = Build(test);
  const Vec3f from(1, 1, 0.5f), floor(1, 1, 0);
  const float before = Radiance(built, from, floor, 50'000, 2).error;
  const std::vector<StereoCamera> rigs = {
      *StereoCamera::FromRig(test::MakeRig({2, 0.2, 1.2}, {0, 1, 0}, 64, 48, 30, 0.1))};
  CacheFill fill;
  fill.paths = 50'000;
  ASSERT_TRUE(FillRadianceCache(*built.scene, &built.lights, {}, 1, rigs, fill, {}).ok());
  const float after = Radiance(built, from, floor, 50'000, 2).error;
  EXPECT_LT(after, 0.6f * before);
}

}  // namespace
}  // namespace parallax
