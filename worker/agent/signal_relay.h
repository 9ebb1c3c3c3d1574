// Passes signals on to the agent, also those that came before there was one. Thread-safe.
#pragma once

#include <mutex>

#include "worker/agent/agent.h"
#include "worker/agent/signal_watch.h"

namespace parallax {

class SignalRelay {
 public:
  // Returns the handlers that feed the relay, which must outlive them.
  SignalWatch::Handlers Handlers(bool exit_when_orphaned);

  // `agent` must live until Detach.
  void Attach(Agent* agent);
  void Detach();

  // Returns whether the parent died.
  bool orphaned() const;

 private:
  void Raise(int count);  // Ends the process at the third signal.
  void DrainLong();
  void Orphan();
  void PassOn();  // Requires mu_.

  mutable std::mutex mu_;
  // Guarded by mu_.
  Agent* agent_ = nullptr;
  int wanted_ = 0;           // SIGTERMs and SIGINTs so far.
  bool long_drain_ = false;  // Whether there was a SIGUSR1.
  bool orphaned_ = false;
};

}  // namespace parallax
