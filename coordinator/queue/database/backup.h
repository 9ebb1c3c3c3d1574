// Backs up a database. A copy appears whole or not at all.
#pragma once

#include <string>

#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"

namespace parallax {

// Writes a consistent copy of the database to `path`; other connections may write to the database
// meanwhile. The copy is durable when the call returns. Errors: kAlreadyExists if `path` exists;
// kResourceExhausted if the disk is full; kUnavailable if SQLite can't copy; those of the file
// system.
absl::Status BackUp(SqliteConnection& db, const std::string& path);

}  // namespace parallax
