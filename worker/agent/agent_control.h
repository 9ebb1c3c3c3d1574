// The hold that other threads have on the agent while its own thread works: they wake it, order it
// to leave and ask how it is. Thread-safe.
#pragma once

#include <condition_variable>
#include <mutex>

#include "common/base/system/clock.h"
#include "worker/agent/health.h"
#include "worker/agent/session/departure.h"

namespace parallax {

class AgentControl {
 public:
  // `clock` must outlive the object.
  explicit AgentControl(Clock& clock) : clock_(clock) {}

  // ---- For other threads
  void Wake();
  // Orders the agent to leave, and wakes it. The most urgent order counts.
  void Order(LeaveOrder order);
  WorkerHealth Health() const;

  // ---- For the agent's thread
  // Notes a round of its loop, and whether it is ready for work.
  void NoteRound(bool ready);
  // Waits until `deadline`, or until it is woken; returns at once if that has happened already.
  void WaitUntil(SteadyTime deadline);
  // Returns the most urgent order so far.
  LeaveOrder order() const;

 private:
  void WakeLocked();

  Clock& clock_;
  mutable std::mutex mu_;
  std::condition_variable wake_;
  // Guarded by mu_.
  bool woken_ = false;
  SteadyTime looked_ = clock_.Steady();  // Time of the last round.
  bool ready_ = false;
  LeaveOrder order_ = LeaveOrder::kStay;
};

}  // namespace parallax
