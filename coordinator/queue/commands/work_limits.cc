#include "coordinator/queue/commands/work_limits.h"

#include <fmt/core.h>

#include "common/base/status.h"

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

std::string Because(std::string_view reason) {
  return reason.empty() ? "" : ": " + std::string(reason);
}

absl::Status WorkLimits::CheckUser(const std::string& user, int64_t studies, int64_t pairs) {
  const UserLimits limits = tables_.options.limits.Of(user);
  if (limits.max_studies == 0 && limits.max_waiting_pairs == 0) return absl::OkStatus();
  int64_t has_studies = 0, has_pairs = 0;
  for (const auto& [id, study] : tables_.ledger.loaded_studies()) {
    if (study.user != user || study.tally.finished || study.tally.cancelled) continue;
    ++has_studies;
    for (const int64_t variant_id : study.variants) {
      ASSIGN_OR_RETURN(const Variant* variant, tables_.ledger.FindVariant(variant_id));
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

absl::Status WorkLimits::SetMaxRunning(int64_t id, int64_t max_running, std::string_view reason,
                                       std::string_view actor) {
  ASSIGN_OR_RETURN(Study * study, tables_.ledger.FindStudy(id));
  const int64_t before = study->tally.max_running;
  if (before == max_running) return absl::OkStatus();
  RETURN_IF_ERROR(
      tables_.db.Run("UPDATE studies SET max_running = ?2 WHERE id = ?1", id, max_running));
  tables_.ledger.Change(*study).max_running = max_running;
  tables_.effects.work_ready = true;
  return tables_.Audit(
      actor, "limit", id,
      fmt::format("max_running {}, was {}{}", max_running, before, Because(reason)));
}

absl::Status WorkLimits::SetPriority(int64_t id, int priority, std::string_view reason,
                                     std::string_view actor) {
  ASSIGN_OR_RETURN(Study * study, tables_.ledger.FindStudy(id));
  const int before = study->tally.priority;
  if (before == priority) return absl::OkStatus();
  RETURN_IF_ERROR(tables_.db.Run("UPDATE studies SET priority = ?2 WHERE id = ?1", id, priority));
  tables_.ledger.Change(*study).priority = priority;
  return tables_.Audit(actor, "priority", id,
                       fmt::format("priority {}, was {}{}", priority, before, Because(reason)));
}

absl::Status WorkLimits::Drain(const v1::DrainOrder& order, bool undo) {
  RETURN_IF_ERROR(
      undo ? tables_.db.Run("DELETE FROM drains WHERE pattern = ?1", order.pattern())
           : tables_.db.Run("INSERT INTO drains(pattern, reason, actor, since_unix_s)"
                            " VALUES (?1, ?2, ?3, ?4) ON CONFLICT DO UPDATE SET reason = ?2",
                            order.pattern(), order.reason(), order.actor(), tables_.Now()));
  if (tables_.db.changes() == 0) return NoSuchDrain(order.pattern());
  ASSIGN_OR_RETURN(std::vector<v1::DrainOrder> drains, ListDrains(tables_.db));
  tables_.effects.drains = std::make_shared<const std::vector<v1::DrainOrder>>(std::move(drains));
  tables_.effects.work_ready |= undo;
  return tables_.Audit(order.actor(), undo ? "undrain" : "drain", 0,
                       order.pattern() + (order.reason().empty() ? "" : ": " + order.reason()));
}

absl::Status WorkLimits::NoSuchDrain(const std::string& pattern) {
  ASSIGN_OR_RETURN(const std::vector<v1::DrainOrder> drains, ListDrains(tables_.db));
  std::string known;
  for (const v1::DrainOrder& drain : drains) {
    known += (known.empty() ? "" : ", ") + ("'" + drain.pattern() + "'");
  }
  return NotFound("no order to drain '{}'; {}", pattern,
                  known.empty() ? "there is none at all" : "there are " + known);
}

absl::StatusOr<std::vector<v1::DrainOrder>> ListDrains(SqliteConnection& db) {
  SqliteQuery query(db, "SELECT pattern, reason, actor, since_unix_s FROM drains ORDER BY pattern");
  return query.Rows([&] {
    v1::DrainOrder drain;
    drain.set_pattern(std::string(query.Text(0)));
    drain.set_reason(std::string(query.Text(1)));
    drain.set_actor(std::string(query.Text(2)));
    drain.set_unix_s(query.Real(3));
    return drain;
  });
}

}  // namespace parallax
