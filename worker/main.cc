// The program `worker`: the agent with the real stages.
#include <tbb/global_control.h>

#include "worker/agent/worker_program.h"
#include "worker/dataset/render_job.h"
#include "worker/materials/user_picture.h"
#include "worker/scene/solve.h"

namespace parallax {
namespace {

class StageRunner final : public JobRunner {
 public:
  explicit StageRunner(const WorkerSettings& settings)
      : threads_(tbb::global_control::max_allowed_parallelism,
                 static_cast<size_t>(settings.threads)) {
    SetPictureRoot(settings.picture_root);
  }

  absl::StatusOr<v1::SolveResult> Solve(const v1::SolveJob& job, const CancelToken& cancel,
                                        const JobProgressFn& progress) override {
    progress(0, job.has_layout() ? "dress" : "layout");
    return parallax::Solve(job, cancel);
  }

  absl::StatusOr<v1::RenderResult> Render(const v1::RenderJob& job, const AttemptFolder& folder,
                                          const CancelToken& cancel,
                                          const JobProgressFn& progress) override {
    RenderJobContext context;
    context.attempt_dir = folder.dir;
    context.attempt_path = folder.path;
    context.cancel = cancel;
    context.progress = [&progress](double fraction) { progress(fraction, "render"); };
    progress(0, "build");
    return RunRenderJob(job, context);
  }

 private:
  tbb::global_control threads_;
};

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  return parallax::RunWorkerProgram(argc, argv, [](const parallax::WorkerSettings& settings) {
    return std::make_unique<parallax::StageRunner>(settings);
  });
}
