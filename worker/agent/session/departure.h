// How a worker leaves when told to. It takes no new work and finishes running jobs; then it hands
// back the jobs that did not end in time; then it leaves, even if some of them have not stopped.
// Single-threaded; used by the agent's own thread.
#pragma once

#include <optional>

#include "common/base/system/clock.h"

namespace parallax {

// An order to leave; later enumerators are more urgent.
enum class LeaveOrder { kStay, kDrainLong, kDrain, kHandBack };

// Time limits of leaving, in seconds.
struct DepartureOptions {
  double grace_s = 0;       // From kDrain until running work is handed back.
  double long_grace_s = 0;  // The same from kDrainLong.
  double hand_back_s = 0;   // How long stopped work may take to notice.
};

// The state machine of leaving.
class Departure {
 public:
  explicit Departure(const DepartureOptions& options) : options_(options) {}

  // The actions that the agent takes now.
  struct Step {
    bool begins = false;            // Take nothing new from now on.
    std::optional<double> grace_s;  // A more urgent order: running work has so long.
    bool hands_back = false;        // Stop what runs.
  };
  // Returns what to do now. `order` is the most urgent order so far.
  Step Advance(LeaveOrder order, SteadyTime now);

  bool leaving() const { return phase_ != Phase::kStaying; }
  // Returns whether the time that stopped work has to end is over.
  bool IsOver(SteadyTime now) const { return phase_ == Phase::kHandingBack && now >= deadline_; }
  // Returns the time at which the results of Advance or IsOver change without a new order;
  // SteadyTime::max() while the worker stays.
  SteadyTime deadline() const { return deadline_; }

 private:
  enum class Phase { kStaying, kFinishing, kHandingBack };

  const DepartureOptions options_;
  Phase phase_ = Phase::kStaying;
  LeaveOrder order_ = LeaveOrder::kStay;  // The order behind deadline_.
  SteadyTime deadline_ = SteadyTime::max();
};

}  // namespace parallax
