#include "worker/agent/signal_relay.h"

#include <algorithm>
#include <cstdlib>

#include "worker/agent/worker_program.h"

namespace parallax {

SignalWatch::Handlers SignalRelay::Handlers(bool exit_when_orphaned) {
  SignalWatch::Handlers handlers;
  handlers.on_signal = [this](int count) { Raise(count); };
  handlers.on_long_drain = [this] { DrainLong(); };
  if (exit_when_orphaned) handlers.on_orphaned = [this] { Orphan(); };
  return handlers;
}

void SignalRelay::Attach(Agent* agent) {
  std::lock_guard lock(mu_);
  agent_ = agent;
  if (long_drain_) agent_->DrainLong();
  if (wanted_ > 0) PassOn();
}

void SignalRelay::Detach() {
  std::lock_guard lock(mu_);
  agent_ = nullptr;
}

bool SignalRelay::orphaned() const {
  std::lock_guard lock(mu_);
  return orphaned_;
}

void SignalRelay::Raise(int count) {
  if (count > 2) std::_Exit(kWorkerIncomplete);
  std::lock_guard lock(mu_);
  wanted_ = std::max(wanted_, count);
  if (agent_ != nullptr) PassOn();
}

void SignalRelay::DrainLong() {
  std::lock_guard lock(mu_);
  long_drain_ = true;
  if (agent_ != nullptr) agent_->DrainLong();
}

void SignalRelay::Orphan() {
  {
    std::lock_guard lock(mu_);
    orphaned_ = true;
  }
  Raise(2);
}

void SignalRelay::PassOn() { wanted_ == 1 ? agent_->Drain() : agent_->HandBack(); }

}  // namespace parallax
