// Users' shares beside their limits (LimitRules): for clients and the page. The scheduler
// keeps its own count (Ledger). Thread-safe. Private to coordinator/queue.
#pragma once

#include <span>
#include <vector>

#include "common/base/status.h"
#include "common/config/check/limit_rules.h"
#include "coordinator/queue/reads/readers.h"

namespace parallax {

// Sets at_limit and held_jobs of each; what is left of a user's limit goes to its studies in their
// order here. Reads the users only if one of the studies is unfinished and of a user with a limit.
// Errors: those of Readers.
absl::Status AddLimits(Readers& readers, const LimitRules& limits,
                       std::span<v1::StudyStatus> studies);

// Users with unfinished studies, and those with rows of their own in `limits`, by name.
// Errors: those of Readers.
absl::StatusOr<std::vector<v1::UserStatus>> UsersWithLimits(Readers& readers,
                                                            const LimitRules& limits);

}  // namespace parallax
