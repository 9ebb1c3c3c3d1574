// Sends each report until it has a definitive answer: OK, ALREADY_DONE, STALE_FENCE, CANCELLED, or
// the status kInvalidArgument. After any other status it backs off and tries again, report by
// report, so that one that the coordinator can't digest does not delay the others.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/base/rng.h"
#include "parallax/v1/service.grpc.pb.h"
#include "worker/agent/outbox.h"

namespace parallax {

// Time limits and back-off of sending, in seconds.
struct ReportSenderOptions {
  double timeout_s = 30;  // Time limit of one attempt to send.
  double backoff_base_s = 0.1;
  double backoff_cap_s = 10;
};

// Thread-safe. Has one thread of its own.
class ReportSender {
 public:
  // Starts with the outbox's leftovers. `on_change` is called, from any thread and without locks
  // held, when a report was tried. `outbox`, `coordinator` and `clock` outlive the sender.
  ReportSender(const ReportSenderOptions& options, Outbox& outbox,
               v1::Coordinator::StubInterface& coordinator, Clock& clock, Rng rng,
               std::function<void()> on_change);
  ~ReportSender();  // Gives up what is in flight; it stays in the outbox.

  // Writes the report to the outbox, then queues it. Sends it even when the disk refuses it
  // (logged).
  void Submit(Report report);
  // Sends reports for this coordinator from now on; others wait. nullopt: it can't be reached, and
  // all wait.
  void SetCoordinator(std::optional<std::string> id);

  // Attempts whose reports to this coordinator have no answer yet.
  std::vector<v1::AttemptId> Pending(const std::string& coordinator_id) const;
  // Whether leftovers for this coordinator were not tried yet: they go before new work.
  bool HasUntriedLeftovers(const std::string& coordinator_id) const;
  size_t pending_in_all() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace parallax
