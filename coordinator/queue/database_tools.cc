#include "coordinator/queue/database_tools.h"

#include <filesystem>
#include <memory>

#include "coordinator/queue/database/backup.h"
#include "coordinator/queue/database/database_file.h"
#include "coordinator/queue/database/migrations.h"
#include "coordinator/queue/database/sqlite.h"
#include "coordinator/queue/reads/auditor.h"

namespace parallax {
namespace {

// Its end puts the log into the file, if the disk lets it.
struct HeldDatabase {
  ~HeldDatabase() {
    if (db != nullptr) PutLogAway(*db, *lock).IgnoreError();
  }
  std::unique_ptr<DatabaseLock> lock;
  std::unique_ptr<SqliteConnection> db;
};

}  // namespace

absl::StatusOr<std::vector<std::string>> AuditDatabaseFile(const std::string& db_path) {
  if (!std::filesystem::exists(db_path)) {
    return NotFound("database {}: no such file", db_path);
  }
  HeldDatabase held;
  ASSIGN_OR_RETURN(held.lock, DatabaseLock::Acquire(db_path));
  ASSIGN_OR_RETURN(held.db, OpenWriter(db_path, ""));
  ASSIGN_OR_RETURN(const auto version, held.db->Integer("PRAGMA user_version"));
  if (version.value_or(0) != NewestSchemaVersion()) {
    return FailedPrecondition("database {} has schema version {}, this program checks version {}",
                              db_path, version.value_or(0), NewestSchemaVersion());
  }
  return AuditDatabase(*held.db, KindRegistry::Builtin());
}

absl::Status VisitStoredOutputs(
    const std::string& db_path,
    const std::function<absl::Status(const std::vector<JobKind::OutputFile>&)>& visit) {
  HeldDatabase held;
  ASSIGN_OR_RETURN(held.lock, DatabaseLock::Acquire(db_path));
  ASSIGN_OR_RETURN(held.db, OpenWriter(db_path, ""));
  const KindRegistry& kinds = KindRegistry::Builtin();
  SqliteQuery results(*held.db, "SELECT stage, bytes FROM results WHERE bytes IS NOT NULL");
  while (results.Next()) {
    for (size_t i = 0; i < kinds.size(); ++i) {
      const auto files = kinds.at(i).StoredFiles(results.Text(0), results.Blob(1));
      if (!files.empty()) RETURN_IF_ERROR(visit(files));
    }
  }
  return results.status();
}

absl::Status BackUpFile(const std::string& db_path, const std::string& path) {
  if (!std::filesystem::exists(db_path)) {
    return NotFound("database {}: no such file", db_path);
  }
  ASSIGN_OR_RETURN(const auto db, OpenReader(db_path, ""));
  return BackUp(*db, path);
}

}  // namespace parallax
