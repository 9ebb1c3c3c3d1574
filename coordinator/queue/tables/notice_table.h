// The tables `notices` and `study_receivers`. A notice is written in the transaction of what it
// tells, so that none is lost; it goes when its receiver has it. Used by the writing thread only,
// inside a transaction, except for ListNotices. Errors of all functions: those of the database.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"
#include "coordinator/queue/notice.h"
#include "parallax/v1/study.pb.h"

namespace parallax {

class NoticeTable {
 public:
  // Both must outlive the object. Without targets, nothing is kept.
  NoticeTable(SqliteConnection& db, const std::vector<std::string>& targets)
      : db_(db), targets_(targets) {}

  // Sets a study's own receiver; one without a URL removes it, and what it is still to be told.
  absl::Status SetReceiver(int64_t study, const v1::NotifySpec& receiver);
  // Notes for each target that wants it that this has happened to a study. It is due at
  // `due_unix_s`, or when an equal one that still waits is due.
  absl::Status Raise(int64_t study, const char* event, double now_unix_s, double due_unix_s);
  // Removes a delivered notice. If it has happened again meanwhile, it is due again then.
  absl::Status End(const Notice& notice, double due_unix_s);
  // Notes that a delivery failed; the next one is not before `due_unix_s`.
  absl::Status Delay(const Notice& notice, double due_unix_s);

 private:
  SqliteConnection& db_;
  const std::vector<std::string>& targets_;
};

// Returns notices that are due, the longest due first, at most `limit`.
absl::StatusOr<std::vector<Notice>> ListNotices(SqliteConnection& db, double now_unix_s, int limit);

}  // namespace parallax
