// Re-derives every invariant of the queue from its tables: what all fault tests end with.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/sqlite.h"

namespace parallax {

// One line for each violation found (at most ten of a kind); empty when everything holds. Reads
// every row. `version` is the generator version whose frame keys are looked up. Call inside a read
// transaction.
absl::StatusOr<std::vector<std::string>> AuditDatabase(SqliteConnection& db);

// The invariants that are stated in SQL, for documentation and tests: each query gives a row a
// violation.
struct Invariant {
  const char* name;
  const char* sql;
};
const std::vector<Invariant>& SqlInvariants();

}  // namespace parallax
