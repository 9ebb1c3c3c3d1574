#include "worker/render/sampler.h"

#include <gtest/gtest.h>

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
        Vec2f p;
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

}  // namespace
}  // namespace parallax
