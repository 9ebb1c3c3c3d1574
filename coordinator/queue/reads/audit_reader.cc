// Reads the audit table for clients. Tables::Audit writes its rows, each in the transaction of
// the change that it records.
#include "common/base/status.h"
#include "coordinator/queue/reads/readers.h"

namespace parallax {
namespace {

constexpr int64_t kEntriesUnlessTold = 100;

}  // namespace

absl::StatusOr<std::vector<v1::AuditEntry>> Readers::ListAudit(
    const v1::ListAuditRequest& request) {
  return Get(deadline_s_, [&](SqliteConnection& db) {
    const int64_t limit = request.limit() > 0 ? request.limit() : kEntriesUnlessTold;
    const std::string sql = std::string(
                                "SELECT id, unix_s, actor, action, coalesce(study_id, 0),"
                                " substr(detail, 1, 2000) FROM audit WHERE ") +
                            (request.study_id() == 0 ? "?1 = 0" : "study_id = ?1") +  // By index.
                            " AND (?2 = 0 OR id < ?2) ORDER BY id DESC LIMIT ?3";
    SqliteQuery query(db, sql.c_str(), request.study_id(), request.before(), limit);
    return query.Rows([&] {
      v1::AuditEntry entry;
      entry.set_id(query.Int(0));
      entry.set_unix_s(query.Real(1));
      entry.set_actor(std::string(query.Text(2)));
      entry.set_action(std::string(query.Text(3)));
      entry.set_study_id(query.Int(4));
      entry.set_detail(std::string(query.Text(5)));
      return entry;
    });
  });
}

absl::StatusOr<std::string> Readers::SubmitterOf(int64_t study) {
  return Get(deadline_s_, [&](SqliteConnection& db) -> absl::StatusOr<std::string> {
    SqliteQuery query(db,
                      "SELECT actor FROM audit WHERE study_id = ?1 AND action = 'submit'"
                      " ORDER BY id LIMIT 1",
                      study);
    if (query.Next()) return std::string(query.Text(0));
    RETURN_IF_ERROR(query.status());
    return NotFound("there is no study {}", study);
  });
}

absl::StatusOr<std::vector<int64_t>> Readers::ListSubmitted(const std::string& prefix,
                                                            const std::string& user) {
  return Get(/*deadline_s=*/0, [&](SqliteConnection& db) {
    // A range, which the index of keys has: no text is behind the last character.
    return db.Integers(
        "SELECT id FROM studies WHERE idempotency_key > ?1"
        " AND idempotency_key < ?1 || char(0x10ffff) AND user = ?2 ORDER BY id",
        prefix, user);
  });
}

}  // namespace parallax
