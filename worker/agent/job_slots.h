// The jobs that run in this worker: `slots` threads, each with at most one attempt, and as many
// more that wait for the next free one, so that a slot needn't wait for its next lease. An attempt
// that ends by itself becomes a report (durable before its slot counts as free); one that was told
// to stop ends in silence.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "parallax/v1/service.pb.h"
#include "worker/agent/job_handler.h"
#include "worker/agent/outbox.h"

namespace parallax {

enum class StopCause {
  kNone,
  kCoordinator,  // Its lease is not ours any more, or its study was cancelled.
  kHandBack,     // Drain: the job is to be READY again.
  kLeaseLost,    // The coordinator was out of reach for the lease's time.
  kHung,         // It made no progress for too long and was reported as failed.
};

struct RunningAttempt {
  v1::AttemptId attempt;
  StopCause stop = StopCause::kNone;
  double fraction = 0;
  std::string stage;
  JobFigures figures;
  double idle_s = 0;     // Since it last told its progress.
  bool waiting = false;  // For a slot.
  // Until it ends, as far as its progress and earlier jobs of its kind tell; infinite if they
  // don't.
  double remaining_s = 0;
};

struct EndedAttempt {
  v1::AttemptId attempt;
  StopCause stop = StopCause::kNone;
  bool reported = false;
  bool succeeded = false;
};

// Thread-safe.
class JobSlots {
 public:
  using ReportSink = std::function<void(Report)>;

  // `sink` and `on_end` are called on the slots' threads. `handlers` and `clock` outlive the slots.
  JobSlots(int slots, std::string worker, const JobHandlers& handlers, Clock& clock,
           ReportSink sink, std::function<void()> on_end);
  ~JobSlots();  // Stops all attempts and waits for them.

  // `folder` is for kinds that write output. It begins when a slot is free. False when as many wait
  // as there are slots.
  bool Start(v1::Lease lease, AttemptFolder folder, std::string coordinator_id);
  // The first cause stays. False when that attempt doesn't run here.
  bool Stop(const v1::AttemptId& attempt, StopCause cause);
  void StopAll(StopCause cause);
  // Gives up an attempt that doesn't come to its end: reports it as failed now. Its thread can't be
  // ended, so its slot stays busy. False when it doesn't run here or was told to stop.
  bool Abandon(const v1::AttemptId& attempt);
  // Takes out those that wait; they leave no trace here.
  std::vector<v1::AttemptId> TakeWaiting();

  std::vector<RunningAttempt> Running() const;  // Including stopped jobs that have not ended yet.
  int busy() const;                             // Including jobs that wait for a slot.
  std::vector<EndedAttempt> TakeEnded();        // Jobs that ended since the last call.

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace parallax
