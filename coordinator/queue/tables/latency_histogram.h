// A histogram with cumulative counts, as Prometheus wants them. Not thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace parallax {

class CountHistogram {
 public:
  // `bounds` must be ascending.
  explicit CountHistogram(std::vector<double> bounds)
      : bounds_(std::move(bounds)), counts_(bounds_.size() + 1, 0) {}

  // Counts a value.
  void Add(double value) {
    ++counts_[static_cast<size_t>(std::lower_bound(bounds_.begin(), bounds_.end(), value) -
                                  bounds_.begin())];
  }
  const std::vector<double>& bounds() const { return bounds_; }
  // Returns the number of values up to each bound, then the number of all values.
  std::vector<uint64_t> Cumulative() const {
    std::vector<uint64_t> sums = counts_;
    for (size_t i = 1; i < sums.size(); ++i) sums[i] += sums[i - 1];
    return sums;
  }

 private:
  std::vector<double> bounds_;
  std::vector<uint64_t> counts_;
};

}  // namespace parallax
