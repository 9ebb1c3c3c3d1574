// Kind `solve`: a seed and a config -> the recipe of a scene.
#include "worker/scene/solve.h"

#include "parallax/v1/jobs.pb.h"
#include "worker/jobs/jobs.h"

namespace parallax {
namespace {

class SolveHandler final : public JobHandler {
 public:
  SolveHandler() : JobHandler("solve", /*writes_output=*/false) {}

  absl::StatusOr<JobOutcome> Run(std::string_view spec, const AttemptFolder&,
                                 const CancelToken& cancel,
                                 const JobProgressFn& progress) override {
    v1::SolveJob job;
    if (!job.ParseFromArray(spec.data(), static_cast<int>(spec.size()))) {
      return absl::InvalidArgumentError("a spec that is no SolveJob");
    }
    progress(0, job.has_layout() ? "dress" : "layout");
    ASSIGN_OR_RETURN(const v1::SolveResult result, Solve(job, cancel));
    return JobOutcome{result.SerializeAsString(), {}};
  }
};

}  // namespace

std::unique_ptr<JobHandler> MakeSolveHandler() { return std::make_unique<SolveHandler>(); }

}  // namespace parallax
