// Histograms with bins of equal width from 0; the last bin counts all larger values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace parallax {

// Counts by bin; bin i covers [i, i + 1) * bin_width.
struct Histogram {
  double bin_width = 1;
  std::vector<int64_t> counts;

  Histogram() = default;
  Histogram(double width, int bins) : bin_width(width), counts(static_cast<size_t>(bins)) {}

  // Counts `value` >= 0.
  void Add(double value) {
    const auto bin = static_cast<size_t>(value / bin_width);
    ++counts[bin < counts.size() ? bin : counts.size() - 1];
  }
  // Adds the counts of `other`. Both must have the same bins, unless this one has none.
  void Merge(const Histogram& other);
  int64_t Total() const;
  // Returns the share of the counts in bins that end at or below `limit`, which should be a bin's
  // edge. 0 when empty.
  double FractionBelow(double limit) const;
  bool operator==(const Histogram&) const = default;
};

// Return the empty histograms of frame.json and of the dataset card. The limits of public training
// code (192, 256, 416, 512, 700, 1000 px) are edges of bins.
inline Histogram DisparityHistogram() { return {4, 1024 / 4 + 1}; }  // Pixels.
inline Histogram DepthHistogram() { return {0.25, 20 * 4 + 1}; }     // Metres.
inline constexpr int kDisparityLimitsPx[] = {192, 256, 416, 512, 700, 1000};

}  // namespace parallax
