#include "worker/agent/session/departure.h"

#include <algorithm>

#include "common/base/seconds.h"

namespace parallax {

Departure::Step Departure::Advance(LeaveOrder order, SteadyTime now) {
  Step step;
  if (phase_ == Phase::kStaying && order != LeaveOrder::kStay) {
    phase_ = Phase::kFinishing;
    step.begins = true;
  }
  if (phase_ != Phase::kFinishing) return step;
  if (order > order_) {
    order_ = order;
    step.grace_s = order == LeaveOrder::kDrainLong ? options_.long_grace_s : options_.grace_s;
    deadline_ = std::min(deadline_, SecondsAfter(now, *step.grace_s));
  }
  if (order == LeaveOrder::kHandBack || now >= deadline_) {
    phase_ = Phase::kHandingBack;
    deadline_ = SecondsAfter(now, options_.hand_back_s);
    step.hands_back = true;
  }
  return step;
}

}  // namespace parallax
