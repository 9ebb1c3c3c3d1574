// How a worker that is told to leave goes: it takes nothing new and finishes what runs, then hands
// back what didn't end in time, then goes without what doesn't stop. Single-threaded; the agent's
// own thread uses it.
#pragma once

#include <optional>

#include "common/base/clock.h"

namespace parallax {

// How a worker was told to leave. Later ones are sharper.
enum class LeaveOrder { kStay, kDrainLong, kDrain, kHandBack };

struct DepartureOptions {
  double grace_s = 0;       // From kDrain until running work is handed back.
  double long_grace_s = 0;  // The same from kDrainLong.
  double hand_back_s = 0;   // How long stopped work may take to notice.
};

class Departure {
 public:
  explicit Departure(const DepartureOptions& options) : options_(options) {}

  // The actions that the agent takes now.
  struct Step {
    bool begins = false;            // Take nothing new from now on.
    std::optional<double> grace_s;  // The order is a sharper one: running work has this long.
    bool hands_back = false;        // Stop what runs.
  };
  // `order`: the sharpest so far.
  Step Advance(LeaveOrder order, SteadyTime now);

  bool leaving() const { return phase_ != Phase::kStaying; }
  // Stopped work had its time to notice.
  bool IsOver(SteadyTime now) const { return phase_ == Phase::kHandingBack && now >= deadline_; }
  // When Advance or IsOver will have something new without a new order; SteadyTime::max() while the
  // worker stays.
  SteadyTime deadline() const { return deadline_; }

 private:
  enum class Phase { kStaying, kFinishing, kHandingBack };

  const DepartureOptions options_;
  Phase phase_ = Phase::kStaying;
  LeaveOrder order_ = LeaveOrder::kStay;  // The one that deadline_ comes from.
  SteadyTime deadline_ = SteadyTime::max();
};

}  // namespace parallax
