#include "transfer_model.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "worker/render/film/exposure.h"

namespace parallax {
namespace {

// Beyond this many standard deviations nothing is summed.
constexpr double kTail = 8;
constexpr int kReadSteps = 257;       // The read noise is summed over so many points.
constexpr double kMostCounts = 1000;  // More counts are summed in steps.

// A distribution of electrons as points with weights, which sum to 1.
using Points = std::vector<std::pair<double, double>>;

Points NormalPoints(double deviation) {
  if (deviation <= 0) return {{0, 1}};
  Points points;
  double sum = 0;
  for (int i = 0; i < kReadSteps; ++i) {
    const double z = kTail * (2.0 * i / (kReadSteps - 1) - 1);
    points.emplace_back(z * deviation, std::exp(-z * z / 2));
    sum += points.back().second;
  }
  for (auto& [value, weight] : points) weight /= sum;
  return points;
}

Points PoissonPoints(double mean) {
  if (mean <= 0) return {{0, 1}};
  const double reach = kTail * std::sqrt(mean) + kTail;
  const double first = std::max(0.0, std::floor(mean - reach)), last = std::ceil(mean + reach);
  const double step = std::max(1.0, std::floor((last - first) / kMostCounts));
  Points points;
  double sum = 0;
  for (double count = first; count <= last; count += step) {
    const double weight = std::exp(count * std::log(mean) - mean - std::lgamma(count + 1));
    points.emplace_back(count, weight);
    sum += weight;
  }
  for (auto& [value, weight] : points) weight /= sum;
  return points;
}

// Mean and variance of `value_of(measured electrons)`.
template <typename Function>
Moments MomentsOver(const NoiseModel& model, double electrons, Function value_of) {
  const double full = kFullWell * model.white_e;
  const Points reads = NormalPoints(model.read_noise_e);
  double mean = 0, square = 0;
  for (const auto& [count, chance] : PoissonPoints(std::min(electrons, full))) {
    for (const auto& [read, share] : reads) {
      const double value = value_of(std::min(count + read, full));
      mean += chance * share * value;
      square += chance * share * value * value;
    }
  }
  return {mean, std::max(0.0, square - mean * mean)};
}

}  // namespace

Moments ModelElectrons(const NoiseModel& model, double electrons) {
  return MomentsOver(model, electrons, [](double measured) { return measured; });
}

Moments ModelLevels(const NoiseModel& model, double electrons) {
  return MomentsOver(model, electrons, [&](double measured) {
    return std::round(double{DisplayLevel(static_cast<float>(measured / model.white_e))});
  });
}

}  // namespace parallax
