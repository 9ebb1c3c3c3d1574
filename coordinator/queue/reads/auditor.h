// Checks every invariant of the queue against its tables. All fault tests end with it.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"
#include "coordinator/queue/job_kind.h"

namespace parallax {

// Returns a line for each violation, at most ten of each invariant; empty if everything holds.
// Reads every row. Each kind of job adds its own invariants to the common ones. Call it inside a
// read transaction. Errors: the database's.
absl::StatusOr<std::vector<std::string>> AuditDatabase(SqliteConnection& db,
                                                       const KindRegistry& kinds);

// Returns the common invariants that are stated in SQL, for documentation and tests. Each query
// gives a row for each violation.
std::span<const JobKind::Invariant> SqlInvariants();

}  // namespace parallax
