// A coordinator's start: writes into its database before any command: a new epoch, the kinds of
// jobs that the program knows, and the limits of users, if they are others than before. Errors: the
// database's, beside those named.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/base/version.h"
#include "common/config/check/limit_rules.h"
#include "coordinator/queue/database/sqlite.h"
#include "coordinator/queue/job_kind.h"

namespace parallax {

// Commits and returns a new epoch. It is greater than the last one and at least the clock's time,
// so a restored backup, which does not have later epochs, starts above them as well. The database
// keeps the versions with it. With `keep_epoch`, returns the last epoch, for fault tests.
absl::StatusOr<uint64_t> RaiseEpoch(SqliteConnection& db, double now_unix_s,
                                    const StageVersions& versions, bool keep_epoch);
// Returns the jobs that are leased since an epoch in which a stage of theirs had another version.
absl::StatusOr<std::vector<int64_t>> LeasesOfOtherVersions(SqliteConnection& db,
                                                           const StageVersions& versions,
                                                           const KindRegistry& kinds);

// Commits which workers have leases and are unheard since this start, beside those that are so
// since an earlier one.
absl::Status NoteUnheard(SqliteConnection& db, double now_unix_s);

// Commits the facts that the schema needs of each kind. Errors: kFailedPrecondition if the database
// has jobs of a kind that `kinds` lacks, and so belongs to another program.
absl::Status EnterKinds(SqliteConnection& db, const KindRegistry& kinds);

// Enters the limits into the audit table unless the last entry of that kind says the same.
absl::Status AuditLimits(SqliteConnection& db, const LimitRules& limits, double now_unix_s);

// Returns 16 hex digits that name the database, derived from its first start. Errors: kDataLoss
// before RaiseEpoch was first called.
absl::StatusOr<std::string> DatabaseId(SqliteConnection& db);

}  // namespace parallax
