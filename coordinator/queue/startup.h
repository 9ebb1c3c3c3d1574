// What a coordinator's start writes into its database before any command: a new epoch, the kinds of
// jobs that the program knows, and the limits of users, if they are others than before. Errors: the
// database's, beside those named.
#pragma once

#include <cstdint>
#include <string>

#include "common/base/status.h"
#include "common/config/limit_rules.h"
#include "coordinator/queue/job_kind.h"
#include "coordinator/queue/sqlite.h"

namespace parallax {

// Commits and returns an epoch above the last one and not below the clock: a restored backup, which
// doesn't know the epochs that came after it, starts above them as well. `keep_epoch`: returns the
// last one, for fault tests.
absl::StatusOr<uint64_t> RaiseEpoch(SqliteConnection& db, double now_unix_s, bool keep_epoch);

// Commits what the schema must know of each kind. Errors: kFailedPrecondition if the database has
// jobs of a kind that `kinds` lacks: it is another program's.
absl::Status EnterKinds(SqliteConnection& db, const KindRegistry& kinds);

// Enters the limits into the audit table unless the last entry of that kind says the same.
absl::Status AuditLimits(SqliteConnection& db, const LimitRules& limits, double now_unix_s);

// 16 hex digits that name the database: made of its first start, of which there is only one.
// Errors: kDataLoss before any epoch is raised.
absl::StatusOr<std::string> DatabaseId(SqliteConnection& db);

}  // namespace parallax
