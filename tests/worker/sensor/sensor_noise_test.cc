#include "worker/sensor/sensor_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

namespace parallax {
namespace {

constexpr int kNoiseSide = 256;
constexpr double kPixels = kNoiseSide * kNoiseSide;
const Rng kStream(SceneSeed{7}, "noise");

struct Moments {
  double mean = 0, variance = 0;
};
Moments MomentsOf(const ImageF& picture) {
  Moments moments;
  for (const float v : picture.values()) moments.mean += double{v} / kPixels;
  for (const float v : picture.values()) {
    moments.variance += (double{v} - moments.mean) * (double{v} - moments.mean) / (kPixels - 1);
  }
  return moments;
}

// The photon transfer curve: variance against mean, in electrons, is a line of slope 1 that begins
// at the square of the read noise.
TEST(AddNoise, FollowsThePhotonTransferCurve) {
  const NoiseModel model{1000, 5};
  for (const double light : {0.0, 0.001, 0.004, 0.016, 0.031, 0.033, 0.12, 0.5, 1.0, 2.5}) {
    ImageF picture(kNoiseSide, kNoiseSide, static_cast<float>(light));
    AddNoise(model, kStream.Child("level", static_cast<uint64_t>(1000 * light)), picture);
    const Moments seen = MomentsOf(picture);
    const double electrons = light * model.white_e;
    const double variance = electrons + model.read_noise_e * model.read_noise_e;
    const double mean_e = seen.mean * model.white_e;
    const double variance_e = seen.variance * model.white_e * model.white_e;
    EXPECT_NEAR(mean_e, electrons, 4 * std::sqrt(variance / kPixels)) << light;
    EXPECT_NEAR(variance_e / variance, 1, 4 * std::sqrt(2 / kPixels) + 0.002) << light;
    std::cout << "[ photon transfer ] mean " << mean_e << " e-, variance " << variance_e
              << " e-^2, model " << variance << "\n";
  }
}

TEST(AddNoise, FewPhotonsComeAsPoissonSaid) {
  const NoiseModel model{1, 0};
  ImageF picture(kNoiseSide, kNoiseSide, 2.0f);
  AddNoise(model, kStream, picture);
  double expected = std::exp(-2.0);
  for (int count = 0; count < 4; ++count) {
    double seen = 0;
    for (const float v : picture.values()) seen += v == static_cast<float>(count) ? 1 : 0;
    EXPECT_NEAR(seen / kPixels, expected, 4 * std::sqrt(expected / kPixels)) << count;
    expected *= 2.0 / (count + 1);
  }
}

TEST(AddNoise, CutsWhatAPixelCanNotHold) {
  ImageF picture(kNoiseSide, 1, 100.0f);
  AddNoise({1000, 5}, kStream, picture);
  for (const float v : picture.values()) {
    EXPECT_LE(double{v}, kFullWell);
    EXPECT_NEAR(double{v}, kFullWell, 0.4);
  }
}

TEST(AddNoise, IsTheStreamsOwnAndIndependentOfOthers) {
  ImageF a(kNoiseSide, kNoiseSide, 0.5f), again = a, b = a;
  AddNoise({1000, 5}, kStream.Child("left"), a);
  AddNoise({1000, 5}, kStream.Child("left"), again);
  AddNoise({1000, 5}, kStream.Child("right"), b);
  EXPECT_EQ(a, again);
  const Moments of_a = MomentsOf(a), of_b = MomentsOf(b);
  double covariance = 0;
  for (size_t i = 0; i < a.values().size(); ++i) {
    covariance +=
        (double{a.values()[i]} - of_a.mean) * (double{b.values()[i]} - of_b.mean) / kPixels;
  }
  const double correlation = covariance / std::sqrt(of_a.variance * of_b.variance);
  EXPECT_LT(std::abs(correlation), 4 / std::sqrt(kPixels));
}

}  // namespace
}  // namespace parallax
