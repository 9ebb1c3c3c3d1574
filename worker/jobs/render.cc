// Kind `render`: the recipe of a scene -> folders of stereo pairs.
#include "parallax/v1/jobs.pb.h"
#include "worker/dataset/render_job.h"
#include "worker/jobs/jobs.h"

namespace parallax {
namespace {

absl::StatusOr<std::vector<OutputFile>> FilesOf(const v1::RenderResult& result,
                                                const std::string& attempt_path) {
  std::vector<OutputFile> files;
  for (const v1::FrameResult& frame : result.frames()) {
    if (frame.path().rfind(attempt_path + "/", 0) != 0) {
      return absl::InternalError("frame " + frame.path() + " is not below its attempt's " +
                                 attempt_path);
    }
    const std::string folder = frame.path().substr(attempt_path.size() + 1);  // "003"
    for (const v1::FileEntry& file : frame.files()) {
      files.push_back({folder + "/" + file.name(), file.size(), file.sha256()});
    }
  }
  return files;
}

class RenderHandler final : public JobHandler {
 public:
  RenderHandler() : JobHandler("render", /*writes_output=*/true) {}

  absl::StatusOr<JobOutcome> Run(std::string_view spec, const AttemptFolder& folder,
                                 const CancelToken& cancel,
                                 const JobProgressFn& progress) override {
    v1::RenderJob job;
    if (!job.ParseFromArray(spec.data(), static_cast<int>(spec.size()))) {
      return absl::InvalidArgumentError("a spec that is no RenderJob");
    }
    RenderJobContext context;
    context.attempt_dir = folder.dir;
    context.attempt_path = folder.path;
    context.cancel = cancel;
    context.progress = [&progress](double fraction) { progress(fraction, "render"); };
    progress(0, "build");
    ASSIGN_OR_RETURN(const v1::RenderResult result, RunRenderJob(job, context));
    JobOutcome outcome;
    ASSIGN_OR_RETURN(outcome.files, FilesOf(result, folder.path));
    outcome.result = result.SerializeAsString();
    return outcome;
  }
};

}  // namespace

std::unique_ptr<JobHandler> MakeRenderHandler() { return std::make_unique<RenderHandler>(); }

}  // namespace parallax
