// Takes results back whose files are damaged or gone, and asks for them again.
//
// A pair of a damaged result is not published any more, and a trained network is none of its study,
// from the commit that finds it out: no study says that it has what it has not. The same commit
// adds jobs that make them again. A study that had ended goes on until they are done.
//
// Used by the writing thread only.
#pragma once

#include <cstdint>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/moves/job_moves.h"
#include "coordinator/queue/moves/waiters.h"

namespace parallax {

class Repair {
 public:
  // All arguments must outlive the object.
  Repair(Tables& tables, JobMoves& jobs, Waiters& waiters)
      : tables_(tables), jobs_(jobs), waiters_(waiters) {}

  // Takes results back that are still as named. Errors: those of JobMoves::AddJob.
  absl::StatusOr<TakenBack> TakeBack(const std::vector<DamagedResult>& damaged,
                                     std::string_view actor);
  // Keeps the state of the pass that looks for damage. Errors: the database's.
  absl::Status KeepScrub(const ScrubState& scrub);

 private:
  using SceneId = std::pair<int64_t, uint32_t>;  // Variant and ordinal.
  // Take back what studies have of a result. Add the pairs and jobs to make again.
  absl::Status TakePairsBack(const DamagedResult& result, TakenBack& taken,
                             std::map<SceneId, std::vector<uint32_t>>& lost);
  absl::Status TakeStudyResultsBack(const DamagedResult& result, std::vector<int64_t>& jobs);
  absl::StatusOr<bool> GoesOn(int64_t study);
  absl::Status AskForPairs(int64_t variant, uint32_t ordinal, std::vector<uint32_t> rigs);
  absl::Status AskForResult(int64_t job);

  Tables& tables_;
  JobMoves& jobs_;
  Waiters& waiters_;
};

}  // namespace parallax
