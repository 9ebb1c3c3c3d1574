// Makes the scenes that variants need, a window of them at a time. Used by the writing thread only.
#pragma once

#include <cstdint>

#include "common/base/status.h"
#include "coordinator/queue/moves/job_moves.h"
#include "coordinator/study/expansion.h"

namespace parallax {

class Expander {
 public:
  // Both arguments must outlive the object.
  Expander(Tables& tables, JobMoves& jobs) : tables_(tables), jobs_(jobs) {}

  // Makes at most `limit` of the scenes that variants need. Returns true if more are needed and may
  // be made now. Errors: those of JobMoves::AddJob.
  absl::StatusOr<bool> Expand(int64_t limit);

 private:
  absl::Status TopUp(Variant& variant, const ScenePlan& plan);

  Tables& tables_;
  JobMoves& jobs_;
};

}  // namespace parallax
