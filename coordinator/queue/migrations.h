// The schema's history: migrations/NNNN_*.sql, embedded in the program, applied in order, forward
// only. The database's user_version is the number of the last one applied.
#pragma once

#include <span>

#include "common/base/status.h"
#include "coordinator/queue/sqlite.h"

namespace parallax {

struct Migration {
  int number;        // From 1, without gaps.
  const char* name;  // "0001_initial"
  const char* sql;
};
std::span<const Migration> AllMigrations();
int64_t NewestSchemaVersion();

// Brings the database to `target` (0: the newest), each migration in its own transaction.
// Errors: kFailedPrecondition for a database from the future; kDataLoss for one that isn't ours.
absl::Status Migrate(SqliteConnection& db, int target = 0);

}  // namespace parallax
