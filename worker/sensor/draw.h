// The numbers of one pair's two cameras, drawn from a SensorConfig.
#pragma once

#include <array>
#include <cstdint>

#include "common/base/ids.h"
#include "parallax/v1/config.pb.h"

namespace parallax {

// The drawn fields of SensorConfig, whose comments explain them. Arrays: left eye, right eye.
struct SensorDraw {
  std::array<double, 2> exposure_ev = {0, 0};
  std::array<double, 2> red_ev = {0, 0};   // Relative to green.
  std::array<double, 2> blue_ev = {0, 0};  // Likewise.
  double white_e = 0;                      // 0: no noise.
  double read_noise_e = 0;
  double psf_sigma_px = 0;
  double defocus_px = 0;
  double focus_m = 2;
  double vignetting = 0;
  bool bayer = false;
  int jpeg_quality = 0;  // 0: no JPEG.
  double exposure_ms = 0;
  // Motion during the exposure beside that of the rig's path, in the left eye's frame.
  std::array<double, 3> shake_m_s = {0, 0, 0};
  std::array<double, 3> shake_rad_s = {0, 0, 0};
};

// The frame whose numbers are drawn. All frames of a path are taken by one device, and all pairs
// that share a left eye as well.
struct SensorFrame {
  SceneSeed seed;
  uint32_t rig = 0;   // The first that has its left eye.
  uint32_t path = 0;  // 0: none.
};

// Returns whether the config asks for other pictures than the rendered ones.
bool SensorIsOn(const v1::SensorConfig& config);

// Draws the numbers for a frame. Each number has a random address of its own: configs that differ
// in one field get the same numbers in all others. Requires a config with all fields set.
SensorDraw DrawSensor(const v1::SensorConfig& config, const SensorFrame& frame);

}  // namespace parallax
