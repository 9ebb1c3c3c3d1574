// Keeps the number of pilots (workers started by a batch system) in step with a coordinator's
// demand, one look at a time.
#pragma once

#include <functional>
#include <string>

#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "coordinator/client/farm/farm_policy.h"

namespace parallax::client {

struct KeeperOptions {
  FarmLimits limits;
  std::string worker_prefix;  // Prefix of the names of pilots' workers: "slurm-".
  bool arrays = true;         // Pilots are submitted as arrays.
  double interval_s = 30;     // Between two looks; longer if pilots don't become workers.
};

// The outside of a keeper: its coordinator, batch system and clock. Tests pass their own.
struct KeeperWorld {
  std::function<absl::StatusOr<std::vector<v1::StudyStatus>>()> studies;
  std::function<absl::StatusOr<std::vector<v1::WorkerStatus>>()> workers;
  std::function<absl::StatusOr<std::vector<Pilot>>()> pilots;
  std::function<absl::StatusOr<std::string>(int)> submit;  // The array's id, or all ids.
  std::function<absl::Status(const std::vector<std::string>&)> cancel;
  Clock* clock = nullptr;
};

// The result of one look: the view, the decision, and the submitted array if there was one.
struct KeeperStep {
  FarmView view;
  FarmDecision decision;
  std::string array;  // Id of the submitted array, or ids of the submitted jobs; empty: none.
  bool is_array = true;
  // Seconds until pilots may be submitted again; the decision's `submit` waits for so long.
  double paused_s = 0;
  bool finished() const;  // No work and no pilot is left.
  // Returns the decision as a line: "12 jobs wait, 4 run; pilots: 2 run, 0 wait, 5 wanted:
  // submitted 3 as array 17".
  std::string Line() const;
  bool did_something() const;
};

// Not thread-safe.
class FarmKeeper {
 public:
  FarmKeeper(KeeperOptions options, KeeperWorld world)
      : options_(options), world_(std::move(world)) {}

  // Looks at coordinator and batch system and decides. Unless `dry`, submits and cancels pilots;
  // does neither if a part of the view is missing. Errors: the first of KeeperWorld's; the next
  // look tries again.
  absl::StatusOr<KeeperStep> Look(bool dry = false);

 private:
  absl::StatusOr<FarmView> See();
  void Remember(const std::vector<v1::WorkerStatus>& workers);

  const KeeperOptions options_;
  const KeeperWorld world_;
  int fruitless_ = 0;  // Submissions in a row that brought no worker.
  double next_submission_s_ = 0;
};

}  // namespace parallax::client
