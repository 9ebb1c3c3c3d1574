#include "worker/agent/session/report_queue.h"

#include <utility>

#include "common/base/seconds.h"

namespace parallax {

void ReportQueue::Add(Report report, bool leftover) {
  using Seconds = Backoff::Seconds;
  entries_.push_back(
      {.report = std::move(report),
       .backoff = Backoff(rng_.Child("report", next_report_++), Seconds(options_.backoff_base_s),
                          Seconds(options_.backoff_cap_s)),
       .leftover = leftover});
}

void ReportQueue::SetCoordinator(std::optional<std::string> id) {
  coordinator_id_ = std::move(id);
  for (Entry& entry : entries_) {
    entry.backoff.Reset();
    entry.due = {};
  }
}

ReportQueue::Entry* ReportQueue::Next() {
  Entry* best = nullptr;
  if (!coordinator_id_) return best;
  for (Entry& entry : entries_) {
    if (entry.report.coordinator_id() != *coordinator_id_) continue;
    if (best == nullptr || entry.due < best->due) best = &entry;
  }
  return best;
}

bool ReportQueue::IsDefinitive(const absl::Status& status) {
  return status.ok() || status.code() == absl::StatusCode::kInvalidArgument;
}

void ReportQueue::Answered(Entry* entry, const absl::Status& status) {
  if (IsDefinitive(status)) {
    entries_.remove_if([entry](const Entry& other) { return &other == entry; });
    return;
  }
  entry->tried = true;
  entry->due = SecondsAfter(clock_.Steady(), entry->backoff.Next().count());
}

std::vector<v1::AttemptId> ReportQueue::Pending(const std::string& coordinator_id) const {
  std::vector<v1::AttemptId> attempts;
  for (const Entry& entry : entries_) {
    if (entry.report.coordinator_id() == coordinator_id) attempts.push_back(entry.report.attempt());
  }
  return attempts;
}

bool ReportQueue::HasUntriedLeftovers(const std::string& coordinator_id) const {
  for (const Entry& entry : entries_) {
    if (entry.leftover && !entry.tried && entry.report.coordinator_id() == coordinator_id) {
      return true;
    }
  }
  return false;
}

}  // namespace parallax
