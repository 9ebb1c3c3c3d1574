#include "worker/dataset/frame/histogram.h"

#include <numeric>

namespace parallax {

void Histogram::Merge(const Histogram& other) {
  if (counts.empty()) *this = Histogram(other.bin_width, static_cast<int>(other.counts.size()));
  for (size_t i = 0; i < counts.size() && i < other.counts.size(); ++i)
    counts[i] += other.counts[i];
}

int64_t Histogram::Total() const {
  return std::accumulate(counts.begin(), counts.end(), int64_t{0});
}

double Histogram::FractionBelow(double limit) const {
  const int64_t total = Total();
  if (total == 0) return 0;
  int64_t below = 0;
  for (size_t i = 0; i < counts.size(); ++i) {
    if (static_cast<double>(i + 1) * bin_width <= limit) below += counts[i];
  }
  return static_cast<double>(below) / static_cast<double>(total);
}

}  // namespace parallax
