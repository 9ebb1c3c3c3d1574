// Reads how long the results of a study took to make. Used inside a read transaction.
#pragma once

#include <cstdint>

#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"
#include "coordinator/queue/job_kind.h"
#include "coordinator/queue/study_costs.h"

namespace parallax {

// Errors: the database's; kDataLoss for results that are none.
absl::StatusOr<StudyCosts> StudyCostsIn(SqliteConnection& db, const KindRegistry& kinds,
                                        int64_t study);

}  // namespace parallax
