// Kind `solve`: a seed and a config -> the recipe of a scene.
#include "common/base/status.h"
#include "parallax/v1/jobs.pb.h"
#include "worker/jobs/jobs.h"
#include "worker/scene/solve_scene.h"

namespace parallax {
namespace {

class SolveHandler final : public JobHandler {
 public:
  explicit SolveHandler(std::shared_ptr<const JobOptions> options)
      : JobHandler("solve", /*writes_output=*/false), options_(std::move(options)) {}

  absl::StatusOr<JobOutcome> Run(std::string_view spec, const AttemptFolder& folder,
                                 const CancelToken& cancel,
                                 const JobProgressFn& progress) override {
    v1::SolveJob job;
    if (!job.ParseFromArray(spec.data(), static_cast<int>(spec.size()))) {
      return InvalidArgument("a spec that is no SolveJob");
    }
    if (folder.store != nullptr) {
      RETURN_IF_ERROR(BringContent(ContentCache(options_->content_cache), *folder.store,
                                   {cancel, [&progress] { progress(0, "content"); }}, job));
    }
    progress(0, job.has_layout() ? "dress" : "layout");
    ASSIGN_OR_RETURN(const v1::SolveResult result, Solve(job, cancel));
    return JobOutcome{result.SerializeAsString(), {}};
  }

 private:
  const std::shared_ptr<const JobOptions> options_;
};

}  // namespace

std::unique_ptr<JobHandler> MakeSolveHandler(std::shared_ptr<const JobOptions> options) {
  return std::make_unique<SolveHandler>(std::move(options));
}

}  // namespace parallax
