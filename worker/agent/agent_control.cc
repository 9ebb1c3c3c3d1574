#include "worker/agent/agent_control.h"

#include <algorithm>

#include "common/base/seconds.h"

namespace parallax {

void AgentControl::Wake() {
  std::lock_guard lock(mu_);
  WakeLocked();
}

// Requires mu_.
void AgentControl::WakeLocked() {
  woken_ = true;
  wake_.notify_all();
}

void AgentControl::Order(LeaveOrder order) {
  std::lock_guard lock(mu_);
  order_ = std::max(order_, order);
  WakeLocked();
}

WorkerHealth AgentControl::Health() const {
  std::lock_guard lock(mu_);
  return {SecondsBetween(looked_, clock_.Steady()), ready_};
}

void AgentControl::NoteRound(bool ready) {
  std::lock_guard lock(mu_);
  looked_ = clock_.Steady();
  ready_ = ready;
}

void AgentControl::WaitUntil(SteadyTime deadline) {
  std::unique_lock lock(mu_);
  wake_.wait_until(lock, deadline, [this] { return woken_; });
  woken_ = false;
}

LeaveOrder AgentControl::order() const {
  std::lock_guard lock(mu_);
  return order_;
}

}  // namespace parallax
