#include "worker/sensor/sensor_noise.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace parallax {
namespace {

// Above this mean a normal distribution stands in for Poisson's: their skews differ by less than
// a fifth.
constexpr double kNormalFrom = 32;

// Source: Devroye, "Non-uniform random variate generation", 1986, X.3 (inversion by sequential
// search).
double Poisson(double mean, Rng& rng) {
  double chance = std::exp(-mean), sum = chance;
  const double u = rng.Uniform();
  int count = 0;
  // 200 lies far beyond what a mean of kNormalFrom ever gives.
  while (u > sum && count < 200) {
    ++count;
    chance *= mean / count;
    sum += chance;
  }
  return count;
}

double Measured(double electrons, double read_noise_e, Rng& rng) {
  if (electrons >= kNormalFrom) {
    return rng.Normal(electrons, std::sqrt(electrons + read_noise_e * read_noise_e));
  }
  return Poisson(electrons, rng) + (read_noise_e > 0 ? rng.Normal(0, read_noise_e) : 0);
}

}  // namespace

template <int channels>
void AddNoise(const NoiseModel& model, const Rng& stream, Image<float, channels>& picture) {
  tbb::parallel_for(0, picture.height(), [&](int y) {
    Rng rng = stream.Child("row", static_cast<uint64_t>(y));
    float* row = picture.At(0, y);
    for (int i = 0; i < channels * picture.width(); ++i) {
      const double light = std::clamp(double{row[i]}, 0.0, kFullWell);
      const double seen = Measured(light * model.white_e, model.read_noise_e, rng);
      row[i] = static_cast<float>(std::min(seen / model.white_e, kFullWell));
    }
  });
}

template void AddNoise<1>(const NoiseModel&, const Rng&, ImageF&);
template void AddNoise<3>(const NoiseModel&, const Rng&, ImageF3&);

}  // namespace parallax
