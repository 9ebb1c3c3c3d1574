#include "worker/agent/session/retirement.h"

#include <algorithm>

#include "common/base/seconds.h"

namespace parallax {

void Retirement::Began(AttemptKey attempt, SteadyTime now) { running_[attempt] = now; }

void Retirement::Ended(AttemptKey attempt, SteadyTime now) {
  const auto began = running_.find(attempt);
  if (began == running_.end()) return;
  longest_ = std::max(longest_, now - began->second);
  running_.erase(began);
}

void Retirement::Observe(bool busy, SteadyTime now) {
  if (busy) {
    idle_since_.reset();
  } else if (!idle_since_) {
    idle_since_ = now;
  }
}

SteadyTime Retirement::LastStart() const {
  return *options_.deadline - std::max(SteadySpan(options_.margin_s), longest_);
}

bool Retirement::TakesWork(SteadyTime now) const { return !options_.deadline || now < LastStart(); }

const char* Retirement::WhyLeave(SteadyTime now) const {
  if (options_.idle_s > 0 && idle_since_ && now >= *idle_since_ + SteadySpan(options_.idle_s)) {
    return "idle";
  }
  if (!options_.deadline) return nullptr;
  if (now >= *options_.deadline - SteadySpan(options_.margin_s)) return "the deadline is near";
  if (idle_since_ && !TakesWork(now)) return "no further job would end before the deadline";
  return nullptr;
}

SteadyTime Retirement::NextLook(SteadyTime until) const {
  if (options_.idle_s > 0 && idle_since_) {
    until = std::min(until, *idle_since_ + SteadySpan(options_.idle_s));
  }
  if (options_.deadline) {
    until = std::min(until, *options_.deadline - SteadySpan(options_.margin_s));
    if (idle_since_) until = std::min(until, LastStart());
  }
  return until;
}

}  // namespace parallax
