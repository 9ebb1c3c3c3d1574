// The jobs in this worker: `slots` threads with at most one attempt each, and as many more attempts
// that wait for the next free slot, so that slots need not wait for their next lease. An attempt
// that ends by itself becomes a report (durable before its slot counts as free); one that was told
// to stop ends silently.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/base/system/clock.h"
#include "parallax/v1/service.pb.h"
#include "worker/agent/attempts/job_handler.h"
#include "worker/agent/attempts/outbox.h"

namespace parallax {

class LogCapture;

// Why an attempt was stopped.
enum class StopCause {
  kNone,
  kCoordinator,  // Its lease is not ours any more, or its study was cancelled.
  kHandBack,     // Drain: the job is to be READY again.
  kLeaseLost,    // The coordinator was out of reach for the lease's time.
  kHung,         // It made no progress for too long and was reported as failed.
};

// A snapshot of one attempt.
struct RunningAttempt {
  v1::AttemptId attempt;
  StopCause stop = StopCause::kNone;
  double fraction = 0;
  std::string stage;
  JobFigures figures;
  double idle_s = 0;     // Seconds since its last progress.
  bool waiting = false;  // It waits for a slot.
  // Estimated seconds to its end, from its progress and earlier jobs of its kind; infinite if
  // unknown.
  double remaining_s = 0;
  std::shared_ptr<const LogCapture> log = nullptr;  // Null until it works.
  std::string program_log = "";                     // Path; empty: it runs no program.
};

// An attempt that left its slot.
struct EndedAttempt {
  v1::AttemptId attempt;
  StopCause stop = StopCause::kNone;
  bool reported = false;
  bool succeeded = false;
};

// Runs attempts on threads of its own. Thread-safe.
class JobSlots {
 public:
  using ReportSink = std::function<void(Report)>;

  // `sink` and `on_end` are called on the slots' threads. `handlers` and `clock` outlive the slots.
  JobSlots(int slots, std::string worker, const JobHandlers& handlers, Clock& clock,
           ReportSink sink, std::function<void()> on_end);
  ~JobSlots();  // Stops all attempts and waits for them.

  // Starts the attempt as soon as a slot is free. `folder` is used by kinds that write output.
  // Returns false if as many attempts wait as there are slots.
  bool Start(v1::Lease lease, AttemptFolder folder, std::string coordinator_id);
  // Stops an attempt; the first cause counts. Returns false if it does not run here.
  bool Stop(const v1::AttemptId& attempt, StopCause cause);
  void StopAll(StopCause cause);
  // Gives up an attempt that does not end: reports it as failed now. A thread can't be killed, so
  // its slot stays busy. Returns false if the attempt does not run here or was told to stop.
  bool Abandon(const v1::AttemptId& attempt);
  // Removes the attempts that wait for a slot and returns them. They are neither reported nor
  // listed afterwards.
  std::vector<v1::AttemptId> TakeWaiting();

  std::vector<RunningAttempt> Running() const;  // Including stopped jobs that have not ended yet.
  int busy() const;                             // Including jobs that wait for a slot.
  std::vector<EndedAttempt> TakeEnded();        // Jobs that ended since the last call.

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace parallax
