// The expected response of a sensor to light that is the same in every pixel: photon transfer of
// the linear camera model, up to the 8-bit levels. Worked out from the distribution of electrons,
// and shares no code with what draws it.
//   Source: EMVA Standard 1288, release 4.0, chapter 2.
#pragma once

#include "worker/sensor/sensor_noise.h"

namespace parallax {

struct Moments {
  double mean = 0, variance = 0;
};

// Returns mean and variance of a pixel's value in electrons that gets `electrons` >= 0 in the mean:
// Poisson's distribution and the read noise, cut where the pixel is full. Requires model.white_e >
// 0.
Moments ModelElectrons(const NoiseModel& model, double electrons);

// Returns the same of the level, 0 to 255, that the renderer's tone curve gives that pixel:
// rounding and the ends of the scale included.
Moments ModelLevels(const NoiseModel& model, double electrons);

}  // namespace parallax
