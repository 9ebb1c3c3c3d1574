// The reports of an agent that have no definitive answer yet (OK, ALREADY_DONE, STALE_FENCE,
// CANCELLED, or the status kInvalidArgument), and which of them is to be sent next. Each report has
// its own back-off, so that a report that the coordinator can't process does not delay the others.
//
// Not thread-safe.
#pragma once

#include <cstdint>
#include <list>
#include <optional>
#include <string>
#include <vector>

#include "common/base/rng.h"
#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "worker/agent/attempts/outbox.h"
#include "worker/agent/session/backoff.h"

namespace parallax {

// Time limits and back-off of sending, in seconds.
struct ReportSenderOptions {
  double timeout_s = 30;  // Time limit of one attempt to send.
  double backoff_base_s = 0.1;
  double backoff_cap_s = 10;
};

class ReportQueue {
 public:
  struct Entry {
    Report report;
    Backoff backoff;
    SteadyTime due{};
    bool leftover = false;  // From an earlier run of the worker.
    bool tried = false;
  };

  // `clock` must outlive the queue.
  ReportQueue(const ReportSenderOptions& options, Clock& clock, Rng rng)
      : options_(options), clock_(clock), rng_(std::move(rng)) {}

  void Add(Report report, bool leftover);
  // Sets the coordinator that is reached now, by its id: only its reports are sent, all others
  // wait, and each is due at once. nullopt: no coordinator is reached, and all reports wait.
  void SetCoordinator(std::optional<std::string> id);
  // Returns the report to be sent next, at its time `due`; null if none can be sent. It stays where
  // it is until Answered removes it.
  Entry* Next();
  // Notes how an attempt to send it has ended. A definitive answer removes it.
  void Answered(Entry* entry, const absl::Status& status);
  static bool IsDefinitive(const absl::Status& status);

  // Returns the attempts whose reports to this coordinator are here.
  std::vector<v1::AttemptId> Pending(const std::string& coordinator_id) const;
  // Returns whether reports from an earlier run of the worker were not tried yet.
  bool HasUntriedLeftovers(const std::string& coordinator_id) const;
  size_t size() const { return entries_.size(); }

 private:
  const ReportSenderOptions options_;
  Clock& clock_;
  const Rng rng_;
  std::list<Entry> entries_;
  std::optional<std::string> coordinator_id_;
  uint64_t next_report_ = 0;
};

}  // namespace parallax
