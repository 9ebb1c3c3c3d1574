#include "coordinator/queue/tables/notice_table.h"

namespace parallax {
namespace {

constexpr int64_t kMostNotices = 10'000;  // The oldest are dropped.
constexpr double kLongestDelay_s = 7200;  // Due later than that: the clock was set back.

}  // namespace

absl::Status NoticeTable::SetReceiver(int64_t study, const v1::NotifySpec& receiver) {
  if (receiver.url().empty()) {
    RETURN_IF_ERROR(db_.Run("DELETE FROM study_receivers WHERE study_id = ?1", study));
    return db_.Run("DELETE FROM notices WHERE study_id = ?1 AND target = ?2", study, kStudyTarget);
  }
  std::string events;
  for (const std::string& event : receiver.on())
    events += (events.empty() ? "," : "") + event + ",";
  return db_.Run(
      "INSERT OR REPLACE INTO study_receivers(study_id, url, events) VALUES (?1, ?2, ?3)", study,
      receiver.url(), events);
}

absl::Status NoticeTable::Raise(int64_t study, const char* event, double now_unix_s,
                                double due_unix_s) {
  for (const std::string& target : targets_) {
    RETURN_IF_ERROR(
        db_.Run("INSERT INTO notices(target, study_id, event, since_unix_s, due_unix_s)"
                " SELECT ?1, ?2, ?3, ?4, ?5 WHERE ?1 <> ?6 OR EXISTS (SELECT 1 FROM study_receivers"
                "  WHERE study_id = ?2 AND (events = '' OR instr(events, ',' || ?3 || ',')))"
                " ON CONFLICT DO UPDATE SET raised = raised + 1",
                target, study, event, now_unix_s, due_unix_s, kStudyTarget));
  }
  if (targets_.empty()) return absl::OkStatus();
  return db_.Run("DELETE FROM notices WHERE id <= (SELECT max(id) FROM notices) - ?1",
                 kMostNotices);
}

absl::Status NoticeTable::End(const Notice& notice, double due_unix_s) {
  RETURN_IF_ERROR(
      db_.Run("DELETE FROM notices WHERE id = ?1 AND raised = ?2", notice.id, notice.raised));
  if (db_.changes() > 0) return absl::OkStatus();
  return db_.Run(
      "UPDATE notices SET raised = raised - ?2, tries = 0, due_unix_s = ?3"
      " WHERE id = ?1 AND raised > ?2",
      notice.id, notice.raised, due_unix_s);
}

absl::Status NoticeTable::Delay(const Notice& notice, double due_unix_s) {
  return db_.Run("UPDATE notices SET tries = tries + 1, due_unix_s = ?2 WHERE id = ?1", notice.id,
                 due_unix_s);
}

absl::StatusOr<std::vector<Notice>> ListNotices(SqliteConnection& db, double now_unix_s,
                                                int limit) {
  SqliteQuery query(db,
                    "SELECT id, target, study_id, event, since_unix_s, raised, tries,"
                    " (SELECT url FROM study_receivers AS r WHERE r.study_id = notices.study_id)"
                    " FROM notices"
                    " WHERE due_unix_s <= ?1 OR due_unix_s > ?1 + ?2"
                    " ORDER BY due_unix_s, id LIMIT ?3",
                    now_unix_s, kLongestDelay_s, limit);
  return query.Rows([&] {
    return Notice{.id = query.Int(0),
                  .target = std::string(query.Text(1)),
                  .study = query.Int(2),
                  .event = std::string(query.Text(3)),
                  .since_unix_s = query.Real(4),
                  .raised = query.Int(5),
                  .tries = static_cast<int>(query.Int(6)),
                  .url = query.IsNull(7) ? "" : std::string(query.Text(7))};
  });
}

}  // namespace parallax
