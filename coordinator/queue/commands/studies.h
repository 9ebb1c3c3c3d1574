// Orders of clients for studies: to submit, cancel and pause them. Used by the writing thread only.
#pragma once

#include <cstdint>
#include <string_view>

#include "common/base/status.h"
#include "coordinator/queue/commands/work_limits.h"
#include "coordinator/queue/moves/job_moves.h"

namespace parallax {

// The commands are those of JobQueue, which documents them. Errors: kNotFound; kAlreadyExists for a
// key of another study; kFailedPrecondition for one that has ended or is over its user's limits;
// those of JobMoves.
class Studies {
 public:
  // All arguments must outlive the object.
  Studies(Tables& tables, JobMoves& jobs, WorkLimits& limits)
      : tables_(tables), jobs_(jobs), limits_(limits) {}

  absl::StatusOr<v1::SubmitReply> Submit(const v1::SubmitRequest& request, std::string_view actor);
  absl::Status Cancel(int64_t study, std::string_view reason, std::string_view actor);
  absl::Status SetPaused(int64_t study, bool paused, std::string_view reason,
                         std::string_view actor);
  absl::Status Comment(int64_t study, std::string_view text, std::string_view actor);

 private:
  Tables& tables_;
  JobMoves& jobs_;
  WorkLimits& limits_;
};

}  // namespace parallax
