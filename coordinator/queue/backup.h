// Copies of a database that appear whole or not at all.
#pragma once

#include <string>

#include "common/base/status.h"
#include "coordinator/queue/sqlite.h"

namespace parallax {

// Writes a consistent copy of the database to `path`, on disk when the call returns, while others
// write. Errors: kAlreadyExists if there is such a file; kResourceExhausted when the disk is full;
// kUnavailable if SQLite can't copy; else as the system says.
absl::Status BackUp(SqliteConnection& db, const std::string& path);

}  // namespace parallax
