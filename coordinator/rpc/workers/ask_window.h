// Bounds how many workers of one class (equal abilities) ask the queue at a time. The window grows
// while the queue has jobs for them, and closes when three workers got no job, until NewRound says
// that there may be work again. So a thousand idle workers do not rush to the queue for one job.
//
// Not thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>

namespace parallax {

class AskWindow {
 public:
  // Returns whether one more worker may ask now. Asked() then counts it.
  bool IsOpen() const { return in_flight_ < width_ && empty_hands_ < kEmptyHandsThatClose; }
  void Asked() { ++in_flight_; }
  // Notes that a worker got `jobs` jobs. `this_round`: no job has become READY since the worker
  // asked.
  void Answered(int jobs, bool this_round) {
    --in_flight_;
    if (jobs == 0 && this_round) ++empty_hands_;
    width_ = jobs == 0 ? std::max(kNarrowest, width_ / 2) : std::min(kWidest, width_ * 2);
  }
  // Opens the window again, because work may be ready.
  void NewRound() { empty_hands_ = 0; }

 private:
  static constexpr int kNarrowest = 4;
  static constexpr int kWidest = 256;
  static constexpr int kEmptyHandsThatClose = 3;  // One refusal may concern that worker alone.

  int width_ = kNarrowest;
  int in_flight_ = 0;
  int empty_hands_ = 0;  // Answers without a job in this round.
};

}  // namespace parallax
