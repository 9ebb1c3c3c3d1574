// Re-derives every invariant of the queue from its tables: what all fault tests end with.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/job_kind.h"
#include "coordinator/queue/sqlite.h"

namespace parallax {

// One line for each violation found (at most ten of a kind); empty when everything holds. Reads
// every row. Each kind adds its own invariants to those that hold for all. Call inside a read
// transaction. Errors: the database's.
absl::StatusOr<std::vector<std::string>> AuditDatabase(SqliteConnection& db,
                                                       const KindRegistry& kinds);

// The invariants of all kinds that are stated in SQL, for documentation and tests: each query gives
// a row a violation.
std::span<const JobKind::Invariant> SqlInvariants();

}  // namespace parallax
