#include "worker/render/surface/sampler.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

namespace parallax {
namespace {

// (0,2)-sequence: the first 2^m points fall once into each box of area 2^-m, whatever its shape.
TEST(Sampler, EveryPairIsStratifiedInAllElementaryBoxes) {
  for (const int m : {2, 4, 5}) {
    const int n = 1 << m;
    for (int dimension = 0; dimension < 6; ++dimension) {
      std::vector<Vec2f> points;
      for (int s = 0; s < n; ++s) {
        Sampler sampler(SampleStream{11, 2, 0, 0}.Hash(), 5, 9, static_cast<uint32_t>(s));
        Vec2f p = Vec2f::Zero();
        for (int d = 0; d <= dimension; ++d) p = sampler.Pair();
        points.push_back(p);
      }
      for (int wide = 0; wide <= m; ++wide) {
        const int columns = 1 << wide, rows = n / columns;
        std::vector<int> seen(static_cast<size_t>(n));
        for (const Vec2f& p : points) {
          ASSERT_GE(p.minCoeff(), 0.0f);
          ASSERT_LT(p.maxCoeff(), 1.0f);
          ++seen[static_cast<size_t>(static_cast<int>(p.x() * static_cast<float>(columns)) * rows +
                                     static_cast<int>(p.y() * static_cast<float>(rows)))];
        }
        for (const int count : seen) ASSERT_EQ(count, 1) << "m " << m << " dimension " << dimension;
      }
    }
  }
}

TEST(Sampler, PairsOfEightAreThoseOfEachAlone) {
  for (uint32_t i = 0; i < 200; ++i) {
    const bool alike = i % 2 == 0;  // One seed and one dimension for all.
    std::vector<Sampler> alone;
    Bits8 seed, sample, dimension;
    for (uint32_t k = 0; k < kLanes; ++k) {
      alone.emplace_back(i * 7919, alike ? i : i + k, 3 * i, (i + 5 * k) % 64);
      for (uint32_t skipped = 0; skipped < (alike ? 2 : k % 3); ++skipped) alone.back().Pair();
      seed[k] = alone.back().seed();
      sample[k] = alone.back().sample();
      dimension[k] = alone.back().dimension();
    }
    Float8 u, v;
    Sampler::Pairs(seed, sample, dimension, &u, &v);
    uint32_t drawn = 0;
    Sampler::Draw(seed, sample, dimension, 3, [&](uint32_t pair, Float8 x, Float8 y) {
      ASSERT_EQ(pair, drawn++);
      for (int k = 0; k < kLanes; ++k) {
        if (pair == 0) {
          EXPECT_EQ(Vec2f(u[k], v[k]), Vec2f(x[k], y[k]));
        }
        ASSERT_EQ(Vec2f(x[k], y[k]), alone[static_cast<size_t>(k)].Pair()) << i << " lane " << k;
      }
    });
    EXPECT_EQ(drawn, 3u);
  }
}

TEST(Sampler, RandomNumbersAreUniformAndUncorrelatedWithEachOtherAndPairs) {
  constexpr uint32_t kBlocks = 1 << 14;
  constexpr int kSeries = 5;  // Two uses, the next dimension, the pair of the same dimension.
  std::array<double, kSeries> sum{};
  std::array<std::array<double, kSeries>, kSeries> product{};
  std::array<int, 16> bins{};
  for (uint32_t block = 0; block < kBlocks; ++block) {
    Bits8 sample;
    for (uint32_t lane = 0; lane < kLanes; ++lane) sample[lane] = block * kLanes + lane;
    const Bits8 seed = Bits8{} + 77u, dimension = Bits8{} + 4u;
    Float8 x[kSeries];
    x[0] = Sampler::Random(seed, sample, dimension, 1);
    x[1] = Sampler::Random(seed, sample, dimension, 2);
    x[2] = Sampler::Random(seed, sample, dimension + 1u, 1);
    Sampler::Pairs(seed, sample, dimension, &x[3], &x[4]);
    for (int lane = 0; lane < kLanes; ++lane) {
      ASSERT_GE(x[0][lane], 0.0f);
      ASSERT_LT(x[0][lane], 1.0f);
      ++bins[static_cast<size_t>(x[0][lane] * 16.0f)];
      for (size_t i = 0; i < kSeries; ++i) {
        sum[i] += x[i][lane] - 0.5;
        for (size_t j = 0; j < i; ++j) product[i][j] += (x[i][lane] - 0.5) * (x[j][lane] - 0.5);
      }
    }
  }
  constexpr double kAll = static_cast<double>(kBlocks) * kLanes;
  // Four to five standard deviations of truly random numbers.
  for (const int bin : bins) EXPECT_NEAR(bin, kAll / 16.0, 4.5 * std::sqrt(kAll / 16.0));
  for (size_t i = 0; i < kSeries; ++i) {
    EXPECT_LT(std::abs(sum[i]), 4.5 * std::sqrt(kAll / 12.0)) << i;
    for (size_t j = 0; j < i; ++j) {
      EXPECT_LT(std::abs(product[i][j]), 4.5 * std::sqrt(kAll) / 12.0) << i << " " << j;
    }
  }
}

// Samples of a square of pixels, which a denoiser averages, are spread as evenly as one pixel's.
TEST(Sampler, SquaresOfPixelsOfAnImageAreStratifiedTogether) {
  constexpr int kLogSamples = 2;
  for (const auto& [x0, y0, side] : {std::array{0, 0, 1}, {6, 3, 1}, {4, 2, 2}, {12, 8, 4}}) {
    for (int dimension = 0; dimension < 4; ++dimension) {
      const int n = side * side << kLogSamples;
      const int columns = side << (kLogSamples / 2), rows = n / columns;
      std::vector<int> seen(static_cast<size_t>(n));
      for (int i = 0; i < n; ++i) {
        const int pixel = i >> kLogSamples;
        Sampler sampler = Sampler::OfImage(SampleStream{11, 2, 0, 0}.Hash(),
                                           static_cast<uint32_t>(x0 + pixel % side),
                                           static_cast<uint32_t>(y0 + pixel / side), kLogSamples,
                                           static_cast<uint32_t>(i & ((1 << kLogSamples) - 1)));
        Vec2f p = Vec2f::Zero();
        for (int d = 0; d <= dimension; ++d) p = sampler.Pair();
        ++seen[static_cast<size_t>(static_cast<int>(p.x() * static_cast<float>(columns)) * rows +
                                   static_cast<int>(p.y() * static_cast<float>(rows)))];
      }
      for (const int count : seen) ASSERT_EQ(count, 1) << side << " at " << x0 << " " << y0;
    }
  }
}

double Correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double ma = 0, mb = 0, ab = 0, aa = 0, bb = 0;
  const auto n = static_cast<double>(a.size());
  for (size_t i = 0; i < a.size(); ++i) ma += a[i] / n, mb += b[i] / n;
  for (size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - ma) * (b[i] - mb);
    aa += (a[i] - ma) * (a[i] - ma);
    bb += (b[i] - mb) * (b[i] - mb);
  }
  return ab / std::sqrt(aa * bb);
}

TEST(Sampler, EyesPixelsRigsAndDimensionsAreUncorrelated) {
  constexpr int kSide = 100;
  std::vector<double> base, eye, rig, neighbour, second, scene;
  const auto first = [](const SampleStream& stream, int x, int y) {
    return static_cast<double>(
        Sampler(stream.Hash(), static_cast<uint32_t>(x), static_cast<uint32_t>(y), 0).Pair().x());
  };
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      base.push_back(first({1, 0, 0, 0}, x, y));
      eye.push_back(first({1, 0, 1, 0}, x, y));
      rig.push_back(first({1, 1, 0, 0}, x, y));
      scene.push_back(first({2, 0, 0, 0}, x, y));
      neighbour.push_back(first({1, 0, 0, 0}, x + 1, y));
      Sampler sampler(SampleStream{1, 0, 0, 0}.Hash(), static_cast<uint32_t>(x),
                      static_cast<uint32_t>(y), 0);
      sampler.Pair();
      second.push_back(sampler.Pair().x());
    }
  }
  for (const auto* other : {&eye, &rig, &neighbour, &second, &scene}) {
    EXPECT_LT(std::abs(Correlation(base, *other)), 0.05);  // 5 standard deviations of 10,000 pairs.
  }
}

TEST(Sampler, EyesRigsAndDimensionsOfImagesAreUncorrelated) {
  constexpr int kSide = 100;
  std::vector<double> base, eye, rig, second, scene;
  const auto first = [](const SampleStream& stream, int x, int y) {
    return Sampler::OfImage(stream.Hash(), static_cast<uint32_t>(x), static_cast<uint32_t>(y), 2,
                            1);
  };
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      Sampler sampler = first({1, 0, 0, 0}, x, y);
      base.push_back(sampler.Pair().x());
      second.push_back(sampler.Pair().x());
      eye.push_back(first({1, 0, 1, 0}, x, y).Pair().x());
      rig.push_back(first({1, 1, 0, 0}, x, y).Pair().x());
      scene.push_back(first({2, 0, 0, 0}, x, y).Pair().x());
    }
  }
  for (const auto* other : {&eye, &rig, &second, &scene}) {
    EXPECT_LT(std::abs(Correlation(base, *other)), 0.05);
  }
}

}  // namespace
}  // namespace parallax
