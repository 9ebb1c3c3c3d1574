#include "worker/sensor/draw.h"

#include <cmath>
#include <numbers>

#include "common/base/rng.h"
#include "common/config/config.h"

namespace parallax {

bool SensorIsOn(const v1::SensorConfig& config) {
  return !config.preset().empty() && config.preset() != "off";
}

namespace {

// A vector of this length in a direction drawn evenly.
std::array<double, 3> Towards(double length, Rng rng) {
  const double z = rng.Uniform(-1, 1), around = rng.Uniform(0, 2 * std::numbers::pi);
  const double across = std::sqrt(1 - z * z);
  return {length * across * std::cos(around), length * across * std::sin(around), length * z};
}

}  // namespace

SensorDraw DrawSensor(const v1::SensorConfig& config, const SensorFrame& frame) {
  const Rng scene(frame.seed, "sensor");
  const Rng moment = scene.Child("rig", frame.rig);
  const Rng root = frame.path > 0 ? scene.Child("path", frame.path) : moment;
  const auto number = [&root](const v1::Distribution& of, const char* address) {
    return Draw(of, root.Child(address).Uniform());
  };
  // Two numbers: the left eye's, and the right eye's, which adds a mismatch to it.
  const auto both = [&](const v1::Distribution& of, const v1::Distribution& mismatch,
                        const std::string& address) {
    const double left = number(of, address.c_str());
    return std::array<double, 2>{left, left + number(mismatch, (address + " mismatch").c_str())};
  };
  SensorDraw draw;
  draw.exposure_ev = both(config.exposure_ev(), config.exposure_mismatch_ev(), "exposure");
  draw.red_ev = both(config.white_balance_ev(), config.white_balance_mismatch_ev(), "red");
  draw.blue_ev = both(config.white_balance_ev(), config.white_balance_mismatch_ev(), "blue");
  draw.white_e = number(config.white_e(), "white");
  draw.read_noise_e = number(config.read_noise_e(), "read noise");
  draw.psf_sigma_px = number(config.psf_sigma_px(), "psf");
  draw.defocus_px = number(config.defocus_px(), "defocus");
  draw.focus_m = number(config.focus_m(), "focus");
  draw.vignetting = number(config.vignetting(), "vignetting");
  draw.bayer = config.bayer();
  draw.jpeg_quality = static_cast<int>(std::lround(number(config.jpeg_quality(), "jpeg")));
  draw.exposure_ms = number(config.exposure_ms(), "exposure time");
  const auto shake = [&](const v1::Distribution& of, const char* address) {
    const Rng stream = moment.Child(address);
    return Towards(Draw(of, stream.Child("size").Uniform()), stream.Child("direction"));
  };
  draw.shake_m_s = shake(config.shake_m_s(), "shake");
  draw.shake_rad_s = shake(config.shake_deg_s(), "turn");
  for (double& turn : draw.shake_rad_s) turn *= std::numbers::pi / 180;
  return draw;
}

}  // namespace parallax
