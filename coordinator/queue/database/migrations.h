// Migrations of the database's schema: migrations/NNNN_*.sql, embedded in the program. They are
// applied in order, forward only. The database's user_version is the number of the last applied
// one.
#pragma once

#include <span>

#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"

namespace parallax {

struct Migration {
  int number;        // From 1, without gaps.
  const char* name;  // "0001_initial"
  const char* sql;
};
// Returns all migrations, sorted by number.
std::span<const Migration> AllMigrations();
int64_t NewestSchemaVersion();

// Brings the database's schema to version `target` (0: the newest), each migration in a transaction
// of its own. Errors: kFailedPrecondition for a database of a newer version; kDataLoss for a
// database that is not ours.
absl::Status Migrate(SqliteConnection& db, int target = 0);

}  // namespace parallax
