// The whole job `solve`: layout (unless given), then dressing: rigs, floating objects, lights, sky
// and materials.
#pragma once

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "parallax/v1/jobs.pb.h"

namespace parallax {

// Runs the job. Deterministic in `job`. A seed without a valid scene gives `rejected`.
// Errors: kCancelled; kInvalidArgument for a config that names unknown classes or materials.
absl::StatusOr<v1::SolveResult> Solve(const v1::SolveJob& job, const CancelToken& cancel);

}  // namespace parallax
