// Noise of measuring light: photon shot noise and read noise.
#pragma once

#include "common/base/rng.h"
#include "common/image/image.h"

namespace parallax {

// The sensor's gain and read noise, in electrons.
struct NoiseModel {
  double white_e = 0;       // Electrons that the value 1 stands for, > 0.
  double read_noise_e = 0;  // Standard deviation.
};

// A pixel saturates at four times white: brighter values are clipped.
inline constexpr double kFullWell = 4;

// Replaces each value x >= 0 by a measurement of it: (Poisson(x * white_e) + Normal(0,
// read_noise_e)) / white_e, so that its mean is x and its variance x / white_e + (read_noise_e /
// white_e)^2. May be below 0. Row y draws from its own address below `stream`, so that the result
// does not depend on threads.
//   Source: EMVA Standard 1288, release 4.0, chapter 2 (linear camera model, photon transfer).
template <int channels>
void AddNoise(const NoiseModel& model, const Rng& stream, Image<float, channels>& picture);

extern template void AddNoise<1>(const NoiseModel&, const Rng&, ImageF&);
extern template void AddNoise<3>(const NoiseModel&, const Rng&, ImageF3&);

}  // namespace parallax
