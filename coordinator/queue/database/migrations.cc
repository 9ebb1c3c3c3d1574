#include "coordinator/queue/database/migrations.h"

#include <fmt/core.h>

#include <string>

namespace parallax {
namespace {

constexpr int64_t kApplicationId = 0x504c5851;  // "PLXQ", shown by file(1).

absl::StatusOr<int64_t> Pragma(SqliteConnection& db, const char* sql) {
  ASSIGN_OR_RETURN(const std::optional<int64_t> value, db.Integer(sql));
  return value.value_or(0);
}

absl::Status CheckForeignKeys(SqliteConnection& db) {
  SqliteQuery query(db, "PRAGMA foreign_key_check");
  if (query.Next()) {
    return DataLoss("table {} names what isn't there", query.Text(0));
  }
  return query.status();
}

// Foreign keys are off meanwhile, so that a table that others name can be made anew; that they hold
// is looked at before the COMMIT.
absl::Status Apply(SqliteConnection& db, const Migration& migration) {
  RETURN_IF_ERROR(db.Execute("PRAGMA foreign_keys = OFF"));
  absl::Status status = db.Execute(
      fmt::format("BEGIN IMMEDIATE;{}\nPRAGMA user_version = {}; PRAGMA application_id = {}",
                  migration.sql, migration.number, kApplicationId));
  if (status.ok()) status = CheckForeignKeys(db);
  if (status.ok()) status = db.Execute("COMMIT");
  if (db.in_transaction()) db.Execute("ROLLBACK").IgnoreError();
  RETURN_IF_ERROR(WithContext(status, std::string("migration ") + migration.name));
  return db.Execute("PRAGMA foreign_keys = ON");
}

}  // namespace

int64_t NewestSchemaVersion() { return AllMigrations().back().number; }

absl::Status Migrate(SqliteConnection& db, int target) {
  ASSIGN_OR_RETURN(const int64_t version, Pragma(db, "PRAGMA user_version"));
  ASSIGN_OR_RETURN(const int64_t application, Pragma(db, "PRAGMA application_id"));
  ASSIGN_OR_RETURN(const int64_t tables, Pragma(db, "SELECT count(*) FROM sqlite_schema"));
  if (application != kApplicationId && (tables > 0 || version > 0)) {
    return DataLoss("not a Parallax queue database");
  }
  if (version > NewestSchemaVersion()) {
    return FailedPrecondition(
        "a database from the future: its schema is version {}, this program knows up to {}; use a "
        "newer program",
        version, NewestSchemaVersion());
  }
  const int64_t wanted = target == 0 ? NewestSchemaVersion() : target;
  for (const Migration& migration : AllMigrations()) {
    if (migration.number <= version || migration.number > wanted) continue;
    RETURN_IF_ERROR(Apply(db, migration));
  }
  return absl::OkStatus();
}

}  // namespace parallax
