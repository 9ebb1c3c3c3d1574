// Durations and the figures that are told of them. Thread-safe.
#pragma once

#include <algorithm>
#include <chrono>
#include <mutex>
#include <vector>

namespace parallax {

using BenchClock = std::chrono::steady_clock;

inline double SecondsSince(BenchClock::time_point begin) {
  return std::chrono::duration<double>(BenchClock::now() - begin).count();
}

class Samples {
 public:
  void Add(double value) {
    const std::lock_guard lock(mutex_);
    values_.push_back(value);
  }
  void Add(const std::vector<double>& values) {
    const std::lock_guard lock(mutex_);
    values_.insert(values_.end(), values.begin(), values.end());
  }
  void Clear() {
    const std::lock_guard lock(mutex_);
    values_.clear();
  }
  size_t count() const {
    const std::lock_guard lock(mutex_);
    return values_.size();
  }
  // p in [0, 1]; 0 without samples.
  double Percentile(double p) const {
    const std::lock_guard lock(mutex_);
    if (values_.empty()) return 0;
    std::vector<double> sorted = values_;
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<size_t>(p * static_cast<double>(sorted.size() - 1))];
  }

 private:
  mutable std::mutex mutex_;
  std::vector<double> values_;  // Guarded by mutex_.
};

}  // namespace parallax
