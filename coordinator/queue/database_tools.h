// Tools for a database file without a JobQueue: `coordinator check` and `coordinator backup`.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/job_kind.h"

namespace parallax {

// Re-derives every invariant of a database that no coordinator has open; empty when all hold.
// Errors: kNotFound; kFailedPrecondition for one that a coordinator has open or of another schema;
// the database's.
absl::StatusOr<std::vector<std::string>> AuditDatabaseFile(const std::string& db_path);

// Calls `visit` with the files of each stored result of a database that no coordinator has open.
// Errors: the first of `visit`; as AuditDatabaseFile.
absl::Status VisitStoredOutputs(
    const std::string& db_path,
    const std::function<absl::Status(const std::vector<JobKind::OutputFile>&)>& visit);

// A copy of a database that a coordinator may have open meanwhile. Errors: kNotFound; as BackUp.
absl::Status BackUpFile(const std::string& db_path, const std::string& path);

}  // namespace parallax
