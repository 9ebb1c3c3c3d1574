// Tools that work on a database file without a JobQueue, for `coordinator check` and `coordinator
// backup`.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/job_kind.h"

namespace parallax {

// Checks every invariant of a database that no coordinator has open. Returns the violations; empty
// if all hold. Errors: kNotFound; kFailedPrecondition if a coordinator has it open, or its schema
// is of another version; the database's.
absl::StatusOr<std::vector<std::string>> AuditDatabaseFile(const std::string& db_path);

// Calls `visit` with the files of each stored result of a database that no coordinator has open.
// Stops at the first error of `visit` and returns it. Errors: those of `visit` and of
// AuditDatabaseFile.
absl::Status VisitStoredOutputs(
    const std::string& db_path,
    const std::function<absl::Status(const std::vector<JobKind::OutputFile>&)>& visit);

// Writes a copy of a database, which a coordinator may have open, to `path`. Errors: kNotFound;
// those of BackUp.
absl::Status BackUpFile(const std::string& db_path, const std::string& path);

}  // namespace parallax
