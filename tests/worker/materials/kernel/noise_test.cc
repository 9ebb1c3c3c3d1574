#include "worker/materials/kernel/noise.h"

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

// Eight random points that move along two random directions.
DualVec8 Moving(Rng& rng) {
  const auto dual = [&] {
    Dual8 d;
    for (int lane = 0; lane < kLanes; ++lane) {
      d.value[lane] = static_cast<float>(rng.Uniform(-3, 3));
      d.dx[lane] = static_cast<float>(rng.Normal());
      d.dy[lane] = static_cast<float>(rng.Normal());
    }
    return d;
  };
  return {dual(), dual(), dual()};
}
Vec3x8 At(const DualVec8& p, float x, float y) {
  const auto at = [&](const Dual8& d) { return d.value + x * d.dx + y * d.dy; };
  return {at(p.x), at(p.y), at(p.z)};
}

// `exact` is that of `f` at `p`, whose values differ as its slopes say; but for a few lanes between
// whose neighbours there is a kink.
template <typename Function>
void ExpectSlopes(const char* what, const DualVec8& p, const Dual8& exact, const Function& f,
                  int* kinks) {
  constexpr float kStep = 1e-3f;
  const Float8 here = f(At(p, 0, 0));
  const Float8 dx = (f(At(p, kStep, 0)) - f(At(p, -kStep, 0))) / (2 * kStep);
  const Float8 dy = (f(At(p, 0, kStep)) - f(At(p, 0, -kStep))) / (2 * kStep);
  for (int lane = 0; lane < kLanes; ++lane) {
    EXPECT_EQ(exact.value[lane], here[lane]) << what;
    *kinks += std::fabs(exact.dx[lane] - dx[lane]) > 0.01f + 0.01f * std::fabs(dx[lane]) ||
              std::fabs(exact.dy[lane] - dy[lane]) > 0.01f + 0.01f * std::fabs(dy[lane]);
  }
}

TEST(Noise, DualsGetTheSlopes) {
  Rng rng(SceneSeed{10}, "noise_test");
  constexpr int kRounds = 400;
  int smooth = 0, kinked = 0;
  for (int i = 0; i < kRounds; ++i) {
    const DualVec8 p = Moving(rng);
    const Float8 footprint = Splat(0.1f);
    ExpectSlopes(
        "Gradient3", p, Gradient3(p, 9), [](const Vec3x8& q) { return Gradient3(q, 9); }, &smooth);
    ExpectSlopes(
        "Gradient2", p, Gradient2(p.x, p.y, 9),
        [](const Vec3x8& q) { return Gradient2(q.x, q.y, 9); }, &smooth);
    ExpectSlopes(
        "Fbm3", p, Fbm3(p, 2.0f, 3, footprint, 9),
        [&](const Vec3x8& q) { return Fbm3(q, 2.0f, 3, footprint, 9); }, &smooth);
    ExpectSlopes(
        "SmoothStep", p, SmoothStep(-1.0f, 2.0f, p.x),
        [](const Vec3x8& q) { return SmoothStep(-1.0f, 2.0f, q.x); }, &smooth);
    ExpectSlopes(
        "Above", p, Above(Fbm3Filtered(p, 2.0f, 2, footprint, 9), 0.1f, 0.5f),
        [&](const Vec3x8& q) { return Above(Fbm3Filtered(q, 2.0f, 2, footprint, 9), 0.1f, 0.5f); },
        &smooth);
    ExpectSlopes(
        "product", p, Sqrt(p.x * p.x + 1.0f) / 3.0f - p.y * (2.0f - p.z),
        [](const Vec3x8& q) { return Sqrt(q.x * q.x + 1.0f) * (1.0f / 3.0f) - q.y * (2.0f - q.z); },
        &smooth);
    ExpectSlopes(
        "kinks", p, Max(Abs(p.x), Min(p.y, Saturate(p.z))),
        [](const Vec3x8& q) { return Max(Abs(q.x), Min(q.y, Saturate(q.z))); }, &kinked);
    ExpectSlopes(
        "CosTurn", p, CosTurn(Fract(0.3f * p.x)),
        [](const Vec3x8& q) { return CosTurn(Fract(0.3f * q.x)); }, &kinked);
    const DualCell8 cell = Cells3(p, 4), tile = Cells2(p.x, p.y, 4);
    ExpectSlopes(
        "f1", p, cell.f1, [](const Vec3x8& q) { return Cells3(q, 4).f1; }, &kinked);
    ExpectSlopes(
        "f2", p, cell.f2, [](const Vec3x8& q) { return Cells3(q, 4).f2; }, &kinked);
    ExpectSlopes(
        "offset", p, cell.offset.z, [](const Vec3x8& q) { return Cells3(q, 4).offset.z; }, &kinked);
    ExpectSlopes(
        "f2 in the plane", p, tile.f2, [](const Vec3x8& q) { return Cells2(q.x, q.y, 4).f2; },
        &kinked);
    ExpectSlopes(
        "offset in the plane", p, tile.offset.x,
        [](const Vec3x8& q) { return Cells2(q.x, q.y, 4).offset.x; }, &kinked);
  }
  EXPECT_LE(smooth, 6 * kRounds * kLanes / 1000);
  EXPECT_LE(kinked, 7 * kRounds * kLanes / 100);
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
