#include "common/math/lanes.h"

#include <gtest/gtest.h>

#include <limits>

namespace parallax {
namespace {

const Float8 kSome = {-3.5f, -1, -0.0f, 0, 0.25f, 1, 2.5f, 100};

TEST(Lanes, FunctionsWorkLaneByLane) {
  const Float8 sine = Sin(kSome), cosine = Cos(kSome), log = Log1p(Abs(kSome)),
               root = Sqrt(Abs(kSome)), sign = CopySign(2, kSome), cut = Clamp(kSome, -1.0f, 2.0f);
  for (int k = 0; k < kLanes; ++k) {
    const float x = kSome[k];
    EXPECT_NEAR(sine[k], std::sin(x), 1e-6f) << x;
    EXPECT_NEAR(cosine[k], std::cos(x), 1e-6f) << x;
    EXPECT_NEAR(log[k], std::log1p(std::abs(x)), 1e-6f) << x;
    EXPECT_FLOAT_EQ(root[k], std::sqrt(std::abs(x))) << x;
    EXPECT_EQ(sign[k], std::copysign(2.0f, x)) << x;
    EXPECT_EQ(cut[k], std::clamp(x, -1.0f, 2.0f)) << x;
  }
  EXPECT_FLOAT_EQ(Sum(kSome), -3.5f - 1 + 0.25f + 1 + 2.5f + 100);
}

TEST(Lanes, ExponentialsAndArcsAreThoseOfTheLibrary) {
  for (int i = -1000; i <= 1000; ++i) {
    const float x = static_cast<float>(i) / 1000;
    EXPECT_NEAR(Acos(Splat(x))[3], std::acos(x), 5e-7f) << x;
    EXPECT_NEAR(Exp(Splat(10 * x))[3] / std::exp(10 * x), 1, 1e-6f) << x;
  }
}

TEST(Lanes, MasksAndBitsSayTheSame) {
  for (int count = -1; count <= kLanes + 1; ++count) {
    const Mask8 first = FirstLanes(count);
    for (int k = 0; k < kLanes; ++k) EXPECT_EQ(first[k], k < count ? -1 : 0);
    EXPECT_EQ(BitsOf(first), (1u << std::clamp(count, 0, kLanes)) - 1);
  }
  EXPECT_EQ(BitsOf(Mask8{0, -1, 0, 0, -1, 0, 0, -1}), 0x92u);
}

TEST(Lanes, MasksKnowWhatIsNotFinite) {
  Float8 x = kSome;
  EXPECT_FALSE(Any(~IsFinite(x)));
  x[6] = std::numeric_limits<float>::quiet_NaN();
  x[1] = -std::numeric_limits<float>::infinity();
  const Mask8 finite = IsFinite(x);
  for (int k = 0; k < kLanes; ++k) EXPECT_EQ(finite[k] != 0, k != 6 && k != 1);
  EXPECT_TRUE(Any(~finite));
}

TEST(Lanes, GatheringReadsWhereEachLaneSays) {
  float table[64];
  for (int i = 0; i < 64; ++i) table[i] = static_cast<float>(i);
  const Int8 index = {7, 0, 31, 2, 2, 30, 11, 5};
  const Float8 one = Gather(table, index);
  Float8 four[4];
  GatherFours(table, index < 31 ? index : Int8{} + 30, 2, four);
  for (int k = 0; k < kLanes; ++k) {
    EXPECT_EQ(one[k], static_cast<float>(index[k]));
    for (int i = 0; i < 4; ++i) {
      EXPECT_EQ(four[i][k], static_cast<float>(2 * std::min(index[k], 30) + i)) << i << " of " << k;
    }
  }
}

TEST(Lanes, RowsBecomeColumns) {
  Float8 rows[kLanes];
  for (int i = 0; i < kLanes; ++i) {
    for (int k = 0; k < kLanes; ++k) rows[i][k] = static_cast<float>(10 * i + k);
  }
  Transpose(rows);
  for (int i = 0; i < kLanes; ++i) {
    for (int k = 0; k < kLanes; ++k) EXPECT_EQ(rows[i][k], static_cast<float>(10 * k + i));
  }
}

TEST(Lanes, VectorsAreThoseOfEigen) {
  Vec3x8 a = Vec3x8::Zero(), b = Vec3x8(Vec3f(0.5f, -2, 3));
  for (int k = 0; k < kLanes; ++k) a.Set(k, Vec3f(kSome[k], 1, -kSome[k]));
  const Vec3x8 sum = a + b * 2.0f - a * b, unit = Normalized(a);
  for (int k = 0; k < kLanes; ++k) {
    const Vec3f x = a.Get(k), y = b.Get(k);
    EXPECT_LT((sum.Get(k) - (x + 2 * y - x.cwiseProduct(y))).norm(), 1e-4f);
    EXPECT_LT((unit.Get(k) - x.normalized()).norm(), 1e-6f);
    EXPECT_FLOAT_EQ(Dot(a, b)[k], x.dot(y));
    EXPECT_EQ(Inner(a, b)[k], x.dot(y));
    EXPECT_EQ(Norm(a)[k], x.norm());
    EXPECT_EQ(Cross(a, b).Get(k), x.cross(y));
    EXPECT_EQ(MaxCoeff(a)[k], x.maxCoeff());
  }
}

}  // namespace
}  // namespace parallax
