// Sends each report until it has a definitive answer; after any other it backs off and tries again.
// ReportQueue says which is next.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/rng.h"
#include "common/base/system/clock.h"
#include "parallax/v1/service.grpc.pb.h"
#include "worker/agent/attempts/outbox.h"
#include "worker/agent/session/report_queue.h"

namespace parallax {

// Thread-safe. Has one thread of its own.
class ReportSender {
 public:
  // Begins with the reports that are left in the outbox. `on_change` is called, on any thread and
  // without locks held, after each attempt to send a report. `outbox`, `coordinator` and `clock`
  // outlive the sender.
  ReportSender(const ReportSenderOptions& options, Outbox& outbox,
               v1::Coordinator::StubInterface& coordinator, Clock& clock, Rng rng,
               std::function<void()> on_change);
  ~ReportSender();  // Stops sending. Unanswered reports stay in the outbox.

  // Writes the report to the outbox, then queues it for sending. If the outbox can't be written, it
  // logs that and sends the report nevertheless.
  void Submit(Report report);
  // Sets the coordinator that is reached now, by its id: only its reports are sent, all others
  // wait. nullopt: no coordinator is reached, and all reports wait.
  void SetCoordinator(std::optional<std::string> id);

  // Returns the attempts whose reports to this coordinator have no definitive answer yet.
  std::vector<v1::AttemptId> Pending(const std::string& coordinator_id) const;
  // Returns whether reports from an earlier run of the worker were not tried yet. The worker takes
  // no new work before that.
  bool HasUntriedLeftovers(const std::string& coordinator_id) const;
  size_t pending_in_all() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace parallax
