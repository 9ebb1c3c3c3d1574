// Who may have how much of the farm: limits of users and studies, and workers that are to be
// drained. Nothing is looked for: what a user has is counted with each move of a job (Ledger), and
// a study without room is passed over as a paused one is. Used by the writing thread only.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/tables/queue_tables.h"

namespace parallax {

class WorkLimits {
 public:
  // `tables` must outlive the object.
  explicit WorkLimits(Tables& tables) : tables_(tables) {}

  // Checks that the user may have `studies` more unfinished studies, with `pairs` more pairs to
  // make. Errors: kFailedPrecondition naming the first limit that does not allow it.
  absl::Status CheckUser(const std::string& user, int64_t studies, int64_t pairs);
  // Bounds a study's leased jobs; see JobQueue. Errors: kNotFound; the database's.
  absl::Status SetMaxRunning(int64_t study, int64_t max_running, std::string_view reason,
                             std::string_view actor);
  // Sets a study's priority; see JobQueue. Errors: kNotFound; the database's.
  absl::Status SetPriority(int64_t study, int priority, std::string_view reason,
                           std::string_view actor);
  // Keeps or undoes an order to drain. Errors: kNotFound if there is no such order to undo.
  absl::Status Drain(const v1::DrainOrder& order, bool undo);

 private:
  absl::Status NoSuchDrain(const std::string& pattern);

  Tables& tables_;
};

// Returns the end of an audit entry's text: ": for the deadline"; empty without a reason.
std::string Because(std::string_view reason);

// Returns the orders to drain, sorted by pattern. Errors: the database's.
absl::StatusOr<std::vector<v1::DrainOrder>> ListDrains(SqliteConnection& db);

}  // namespace parallax
