// How much users and studies may have. Nothing is looked for: what a user has is counted with each
// move of a job (Ledger), and a study without room is passed over as a paused one is.
#include <fmt/core.h>

#include <algorithm>

#include "common/base/status.h"
#include "coordinator/queue/commands/machine.h"

namespace parallax {
namespace {

// "submitter ada has 4 unfinished studies, 1 more is over max_studies 4 (for submitter *)".
absl::Status OverLimit(const std::string& user, const UserLimits& limits, int64_t has,
                       const char* what, int64_t more, const std::string& limit) {
  return FailedPrecondition(
      "{} has {} {}, {} more would be over the limit {} that this farm's operator set{}: wait "
      "until some are done, or cancel a study",
      user, has, what, more, limit, limits.rule.empty() ? "" : " for " + limits.rule);
}

}  // namespace

absl::Status Machine::CheckUser(const std::string& user, int64_t studies, int64_t pairs) {
  const UserLimits limits = options_.limits.Of(user);
  if (limits.max_studies == 0 && limits.max_waiting_pairs == 0) return absl::OkStatus();
  int64_t has_studies = 0, has_pairs = 0;
  for (const auto& [id, study] : ledger_.loaded_studies()) {
    if (study.user != user || study.tally.finished || study.tally.cancelled) continue;
    ++has_studies;
    for (const int64_t variant_id : study.variants) {
      ASSIGN_OR_RETURN(const Variant* variant, ledger_.FindVariant(variant_id));
      if (!variant->tally.problem.empty()) continue;  // It gave up.
      has_pairs += variant->pairs_wanted - variant->tally.pairs_done;
    }
  }
  if (limits.max_studies > 0 && has_studies + studies > limits.max_studies) {
    return OverLimit(user, limits, has_studies, "unfinished studies", studies,
                     fmt::format("max_studies {}", limits.max_studies));
  }
  if (limits.max_waiting_pairs > 0 && has_pairs + pairs > limits.max_waiting_pairs) {
    return OverLimit(user, limits, has_pairs, "pairs waiting", pairs,
                     fmt::format("max_waiting_pairs {}", limits.max_waiting_pairs));
  }
  return absl::OkStatus();
}

int64_t Machine::RoomOf(const Study& study) {
  return std::min(RoomUnder(study.tally.max_running, study.tally.running),
                  RoomUnder(study.share->limits.max_running, study.share->running));
}

absl::Status Machine::SetMaxRunning(int64_t id, int64_t max_running, std::string_view reason,
                                    std::string_view actor) {
  ASSIGN_OR_RETURN(Study * study, ledger_.FindStudy(id));
  const int64_t before = study->tally.max_running;
  if (before == max_running) return absl::OkStatus();
  RETURN_IF_ERROR(db_.Run("UPDATE studies SET max_running = ?2 WHERE id = ?1", id, max_running));
  ledger_.Change(*study).max_running = max_running;
  effects_.work_ready = true;
  return Audit(actor, "limit", id,
               fmt::format("max_running {}, was {}{}", max_running, before,
                           reason.empty() ? "" : ": " + std::string(reason)));
}

}  // namespace parallax
