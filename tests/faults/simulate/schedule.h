// Virtual time for a simulation in one thread: events in the order of their times, machines' clocks
// that drift from it, and the story of what happened.
#pragma once

#include <fmt/core.h>

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <utility>

#include "common/base/seconds.h"
#include "common/base/system/clock.h"

namespace parallax::faults {

class Schedule {
 public:
  // Returns the seconds of virtual time since the beginning.
  double now() const { return now_s_; }
  int64_t events() const { return ran_; }
  // Runs `event` after so many seconds. Events of one moment run in the order of these calls.
  void After(double seconds, std::function<void()> event) {
    waiting_.emplace(std::pair(now_s_ + std::max(0.0, seconds), next_++), std::move(event));
  }
  // Runs the next event if it is due by `until_s`; otherwise sets the time to that and returns
  // false.
  bool RunNext(double until_s) {
    if (waiting_.empty() || waiting_.begin()->first.first > until_s) {
      now_s_ = std::max(now_s_, until_s);
      return false;
    }
    auto next = waiting_.extract(waiting_.begin());
    now_s_ = next.key().first;
    ++ran_;
    next.mapped()();
    return true;
  }

 private:
  double now_s_ = 0;
  int64_t ran_ = 0;
  uint64_t next_ = 0;
  std::map<std::pair<double, uint64_t>, std::function<void()>> waiting_;
};

// A machine's clocks: both run `rate` times as fast as virtual time, and the wall clock jumps.
class MachineClock final : public Clock {
 public:
  MachineClock(const Schedule& schedule, double rate) : schedule_(schedule), rate_(rate) {}

  double UnixSeconds() override { return 1.8e9 + jumps_s_ + rate_ * schedule_.now(); }
  SteadyTime Steady() override {
    return SecondsAfter(SteadyTime(), 1000 + rate_ * schedule_.now());
  }
  void JumpWall(double seconds) { jumps_s_ += seconds; }
  // Returns the seconds of virtual time until this clock shows `when`, and a little more.
  double Until(SteadyTime when) {
    return std::max(0.0, SecondsBetween(Steady(), when) / rate_) + 1e-6;
  }

 private:
  const Schedule& schedule_;
  const double rate_;
  double jumps_s_ = 0;
};

// What happened, one line an event; empty unless it is asked for.
class Story {
 public:
  Story(const Schedule& schedule, bool wanted) : schedule_(schedule), wanted_(wanted) {}

  template <typename... Args>
  void Tell(fmt::format_string<Args...> format, Args&&... args) {
    if (!wanted_) return;
    text_ += fmt::format("{:12.6f} ", schedule_.now());
    text_ += fmt::format(format, std::forward<Args>(args)...);
    text_ += '\n';
  }
  const std::string& text() const { return text_; }

 private:
  const Schedule& schedule_;
  const bool wanted_;
  std::string text_;
};

}  // namespace parallax::faults
