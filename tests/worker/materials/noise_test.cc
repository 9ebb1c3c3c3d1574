#include "worker/materials/noise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/base/rng.h"

namespace parallax::noise {
namespace {

struct Moments {
  double mean = 0, std = 0, low = 1e9, high = -1e9;
};

template <typename Sample>
Moments MomentsOf(const Sample& sample, int count = 40000) {
  Rng rng(SceneSeed{5}, "noise_test");
  Moments m;
  double squares = 0;
  for (int i = 0; i < count; ++i) {
    const Vec3f p(static_cast<float>(rng.Uniform(-500, 500)),
                  static_cast<float>(rng.Uniform(-500, 500)),
                  static_cast<float>(rng.Uniform(-500, 500)));
    const double value = sample(p);
    m.mean += value / count;
    squares += value * value / count;
    m.low = std::min(m.low, value);
    m.high = std::max(m.high, value);
  }
  m.std = std::sqrt(squares - m.mean * m.mean);
  return m;
}

TEST(Noise, GradientNoiseHasMeanZeroAndTheStatedSpread) {
  for (const Moments& m : {MomentsOf([](const Vec3f& p) { return Gradient3(p, 3); }),
                           MomentsOf([](const Vec3f& p) { return Gradient2(p.x(), p.y(), 3); })}) {
    EXPECT_NEAR(m.mean, 0.0, 0.01);
    EXPECT_NEAR(m.std, 0.3, 0.04);
    EXPECT_GT(m.high, 0.7);
    EXPECT_LT(m.high, 1.4);
    EXPECT_LT(m.low, -0.7);
    EXPECT_GT(m.low, -1.4);
  }
}

TEST(Noise, GradientNoiseIsContinuousAcrossCells) {
  Rng rng(SceneSeed{6}, "noise_test");
  for (int i = 0; i < 20000; ++i) {
    Vec3f p(static_cast<float>(rng.Uniform(-8, 8)), static_cast<float>(rng.Uniform(-8, 8)),
            static_cast<float>(rng.Uniform(-8, 8)));
    const Vec3f q = p + Vec3f(1e-3f, -1e-3f, 1e-3f);
    EXPECT_NEAR(Gradient3(p, 9), Gradient3(q, 9), 0.02);
    EXPECT_NEAR(Gradient2(p.x(), p.y(), 9), Gradient2(q.x(), q.y(), 9), 0.02);
  }
}

TEST(Noise, CellsFindTheNearestPointsOfAllCells) {
  // The nearest distance is 1-Lipschitz: a missed neighbour shows as a jump.
  Rng rng(SceneSeed{7}, "noise_test");
  const auto draw = [&] { return static_cast<float>(rng.Uniform(-8, 8)); };
  for (int i = 0; i < 2500; ++i) {
    Vec3x8 p;
    for (int lane = 0; lane < kLanes; ++lane) p.Set(lane, Vec3f(draw(), draw(), draw()));
    const Vec3x8 q = p + Vec3f(2e-3f, 1e-3f, -2e-3f);
    const Cell8 a = Cells3(p, 4), b = Cells3(q, 4);
    const Cell8 c = Cells2(p.x, p.y, 4), d = Cells2(q.x, q.y, 4);
    for (int lane = 0; lane < kLanes; ++lane) {
      EXPECT_LE(a.f1[lane], a.f2[lane]);
      EXPECT_NEAR(a.f1[lane], a.offset.Get(lane).norm(), 1e-4);
      EXPECT_LE(std::fabs(a.f1[lane] - b.f1[lane]), 3.1e-3);
      EXPECT_LE(c.f1[lane], c.f2[lane]);
      EXPECT_LE(std::fabs(c.f1[lane] - d.f1[lane]), 2.4e-3);
    }
  }
}

// The search skips cells that are too far; what it finds must not depend on what it skipped for the
// other seven.
TEST(Noise, EveryFeaturePointIsItsOwnNearest) {
  Rng rng(SceneSeed{9}, "noise_test");
  const auto draw = [&] { return static_cast<float>(rng.Uniform(-8, 8)); };
  for (int i = 0; i < 1500; ++i) {
    const float jitter = static_cast<float>(rng.Uniform(0.2, 1));
    Vec3x8 p;
    for (int lane = 0; lane < kLanes; ++lane) p.Set(lane, Vec3f(draw(), draw(), draw()));
    const Cell8 cell = Cells3(p, 4, jitter), tile = Cells2(p.x, p.y, 4, jitter);
    // The feature points themselves, and ways from them to the queries.
    const Cell8 there = Cells3(p - cell.offset, 4, jitter);
    const Vec3x8 q = p - tile.offset;
    const Cell8 tile_there = Cells2(q.x, q.y, 4, jitter);
    for (int lane = 0; lane < kLanes; ++lane) {
      EXPECT_NEAR(there.f1[lane], 0.0f, 4e-6f);
      EXPECT_EQ(there.id[lane], cell.id[lane]);
      EXPECT_NEAR(tile_there.f1[lane], 0.0f, 4e-6f);
      EXPECT_EQ(tile_there.id[lane], tile.id[lane]);
      const Cell8 alone = Cells3(Vec3x8(p.Get(lane)), 4, jitter);
      EXPECT_EQ(alone.f1[0], cell.f1[lane]);
      EXPECT_EQ(alone.f2[0], cell.f2[lane]);
      EXPECT_EQ(alone.id[0], cell.id[lane]);
    }
  }
}

TEST(Noise, EightPointsGetTheBitsOfOne) {
  Rng rng(SceneSeed{8}, "noise_test");
  for (int i = 0; i < 500; ++i) {
    Vec3x8 p;
    Float8 footprint;
    for (int lane = 0; lane < kLanes; ++lane) {
      p.Set(lane,
            Vec3f(static_cast<float>(rng.Uniform(-8, 8)), static_cast<float>(rng.Uniform(-8, 8)),
                  static_cast<float>(rng.Uniform(-8, 8))));
      footprint[lane] = static_cast<float>(rng.Uniform(0, 0.3));
    }
    const Float8 solid = Gradient3(p, 9), plane = Gradient2(p.x, p.y, 9);
    const Float8 sum = Fbm3(p, 0.5f, 4, footprint, 9), turn = CosTurn(p.x);
    const Cell8 flat = Cells2(p.x, p.y, 9);
    for (int lane = 0; lane < kLanes; ++lane) {
      const Vec3f q = p.Get(lane);
      EXPECT_EQ(solid[lane], Gradient3(q, 9));
      EXPECT_EQ(plane[lane], Gradient2(q.x(), q.y(), 9));
      EXPECT_EQ(sum[lane], Fbm3(q, 0.5f, 4, footprint[lane], 9));
      EXPECT_EQ(turn[lane], CosTurn(q.x()));
      const Cell tile = Cells2(q.x(), q.y(), 9);
      EXPECT_EQ(flat.f1[lane], tile.f1);
      EXPECT_EQ(flat.f2[lane], tile.f2);
      EXPECT_EQ(flat.id[lane], tile.id);
    }
  }
}

TEST(Noise, CosTurnFollowsTheCosine) {
  for (int i = -300; i <= 300; ++i) {
    const float x = static_cast<float>(i) * 0.0173f;
    EXPECT_NEAR(CosTurn(x), std::cos(2.0 * 3.14159265358979 * x), 1e-3);
  }
}

TEST(Noise, FadeIsOneFarAboveAndZeroBelowNyquist) {
  EXPECT_EQ(Fade(0.01f, 0.0f), 1.0f);
  EXPECT_EQ(Fade(0.01f, 0.0025f), 1.0f);
  EXPECT_EQ(Fade(0.01f, 0.005f), 0.0f);
  EXPECT_GT(Fade(0.01f, 0.003f), Fade(0.01f, 0.004f));
}

}  // namespace
}  // namespace parallax::noise
