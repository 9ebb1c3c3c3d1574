#include "worker/sensor/draw.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/config/config.h"
#include "common/config/sensor_presets.h"

namespace parallax {
namespace {

constexpr SceneSeed kSeed{42};

v1::SensorConfig Preset(std::string_view name) {
  v1::SensorConfig sensor;
  TakeSensorPreset(name, &sensor);
  return sensor;
}

void SetGaussian(double std, double bound, v1::Distribution* distribution) {
  auto& gaussian = *distribution->mutable_clip_gaussian();
  gaussian.set_mean(0);
  gaussian.set_std(std);
  gaussian.set_low(-bound);
  gaussian.set_high(bound);
}

TEST(DrawSensor, IdealSensorsChangeNothingAndOffOnesAreOff) {
  const SensorDraw draw = DrawSensor(Preset("ideal"), {kSeed, 3});
  EXPECT_EQ(draw.exposure_ev[0], 0);
  EXPECT_EQ(draw.exposure_ev[1], 0);
  EXPECT_EQ(draw.white_e, 0);
  EXPECT_EQ(draw.psf_sigma_px, 0);
  EXPECT_EQ(draw.jpeg_quality, 0);
  EXPECT_FALSE(draw.bayer);
  EXPECT_TRUE(SensorIsOn(Preset("ideal")));
  EXPECT_FALSE(SensorIsOn(Preset("off")));
  EXPECT_FALSE(SensorIsOn({}));
}

TEST(DrawSensor, MismatchOfTheEyesHasTheConfiguredSize) {
  v1::SensorConfig sensor = Preset("ideal");
  sensor.mutable_exposure_ev()->mutable_uniform()->set_low(-2);
  sensor.mutable_exposure_ev()->mutable_uniform()->set_high(2);
  SetGaussian(0.2, 2, sensor.mutable_exposure_mismatch_ev());
  SetGaussian(0.1, 1, sensor.mutable_white_balance_mismatch_ev());
  constexpr int kPairs = 2000;
  double sum = 0, square = 0, red = 0, blue = 0, red_blue = 0;
  for (uint32_t rig = 0; rig < kPairs; ++rig) {
    const SensorDraw draw = DrawSensor(sensor, {kSeed, rig});
    const double mismatch = draw.exposure_ev[1] - draw.exposure_ev[0];
    sum += mismatch;
    square += mismatch * mismatch;
    const double r = draw.red_ev[1] - draw.red_ev[0], b = draw.blue_ev[1] - draw.blue_ev[0];
    red += r * r;
    blue += b * b;
    red_blue += r * b;
  }
  // Standard errors: 0.2 / sqrt(2000) = 0.0045 of the mean, 0.2 / sqrt(4000) = 0.0032 of the std.
  EXPECT_NEAR(sum / kPairs, 0, 0.018);
  EXPECT_NEAR(std::sqrt(square / kPairs), 0.2, 0.0128);
  EXPECT_NEAR(std::sqrt(red / kPairs), 0.1, 0.0064);
  EXPECT_NEAR(std::sqrt(blue / kPairs), 0.1, 0.0064);
  EXPECT_NEAR(red_blue / kPairs, 0, 0.001) << "red and blue are drawn one by one";
}

TEST(DrawSensor, AnotherFieldLeavesTheOtherDrawsAlone) {
  const v1::SensorConfig webcam = Preset("webcam");
  v1::SensorConfig other = webcam;
  other.mutable_white_e()->set_constant(77);
  other.mutable_exposure_mismatch_ev()->set_constant(0);
  const SensorDraw a = DrawSensor(webcam, {kSeed, 5}), b = DrawSensor(other, {kSeed, 5});
  EXPECT_EQ(b.white_e, 77);
  EXPECT_EQ(a.exposure_ev[0], b.exposure_ev[0]);
  EXPECT_EQ(b.exposure_ev[0], b.exposure_ev[1]);
  EXPECT_EQ(a.read_noise_e, b.read_noise_e);
  EXPECT_EQ(a.vignetting, b.vignetting);
  EXPECT_EQ(a.jpeg_quality, b.jpeg_quality);
  EXPECT_NE(a.read_noise_e, DrawSensor(webcam, {kSeed, 6}).read_noise_e);
  EXPECT_NE(a.read_noise_e, DrawSensor(webcam, {SceneSeed{43}, 5}).read_noise_e);
}

TEST(DrawSensor, FramesOfAPathHaveOneDeviceThatIsShakenAnewInEach) {
  v1::SensorConfig webcam = Preset("webcam");
  webcam.mutable_shake_m_s()->set_constant(0.5);
  webcam.mutable_shake_deg_s()->set_constant(10);
  const SensorDraw a = DrawSensor(webcam, {kSeed, 5, 1}), b = DrawSensor(webcam, {kSeed, 6, 1}),
                   other = DrawSensor(webcam, {kSeed, 7, 2});
  EXPECT_EQ(a.exposure_ev, b.exposure_ev);
  EXPECT_EQ(a.read_noise_e, b.read_noise_e);
  EXPECT_NE(a.read_noise_e, other.read_noise_e);
  EXPECT_NE(a.shake_m_s, b.shake_m_s);
  const auto length = [](const std::array<double, 3>& v) { return std::hypot(v[0], v[1], v[2]); };
  EXPECT_NEAR(length(a.shake_m_s), 0.5, 1e-12);
  EXPECT_NEAR(length(a.shake_rad_s), 10 * std::numbers::pi / 180, 1e-12);
}

}  // namespace
}  // namespace parallax
