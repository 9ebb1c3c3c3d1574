// Reads what the tables say of files in the store. Used inside a read transaction, or by the
// writing thread. Errors: those of the database.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"
#include "coordinator/queue/stored_outputs.h"

namespace parallax {

// The reads of JobQueue, which documents them (job_queue.h).
absl::StatusOr<std::vector<StoredOutput>> StoredOutputsIn(SqliteConnection& db,
                                                          const KindRegistry& kinds,
                                                          const std::string& after, int limit);
absl::StatusOr<std::set<std::string>> AttemptFoldersIn(SqliteConnection& db,
                                                       const KindRegistry& kinds);
absl::StatusOr<std::vector<std::string>> UsesOfIn(SqliteConnection& db, const Sha256Digest& key);
absl::StatusOr<std::optional<ScrubState>> ScrubIn(SqliteConnection& db);

// Reads the store's id, and a sample of the newest results' files.
absl::StatusOr<KnownStore> ReadKnownStore(SqliteConnection& db, const KindRegistry& kinds);
// Commits the id of the database's store, and says so in the audit table if it was another one.
absl::Status EnterStore(SqliteConnection& db, const std::string& before, const std::string& id,
                        double now_unix_s);

}  // namespace parallax
