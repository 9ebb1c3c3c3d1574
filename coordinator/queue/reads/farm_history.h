// How the farm did over the last day: a sample a minute in a ring, for the page's charts. The
// database keeps them too (JobQueue::KeepSample), so that a restart goes on with them. Not
// thread-safe.
#pragma once

#include <cstdint>
#include <deque>

namespace parallax {

// The farm's figures at one moment.
struct HistorySample {
  double unix_s = 0;
  double pairs_per_hour = 0;
  int64_t ready = 0, running = 0, waiting = 0;  // Jobs; waiting: BLOCKED or RETRY_WAIT.
  int64_t workers = 0, slots = 0, busy = 0;
};

class History {
 public:
  static constexpr double kEvery_s = 60;
  static constexpr size_t kMost = 24 * 60;

  // Adds a sample, unless the last one is less than a minute older. Returns whether the sample was
  // kept.
  bool Add(const HistorySample& sample) {
    if (!samples_.empty() && sample.unix_s < samples_.back().unix_s + kEvery_s &&
        sample.unix_s >= samples_.back().unix_s) {
      return false;
    }
    samples_.push_back(sample);
    if (samples_.size() > kMost) samples_.pop_front();
    return true;
  }
  const std::deque<HistorySample>& samples() const { return samples_; }  // The oldest first.

 private:
  std::deque<HistorySample> samples_;
};

}  // namespace parallax
