// Kind `render`: the recipe of a scene -> folders of stereo pairs.
#include <algorithm>
#include <set>

#include "common/base/status.h"
#include "parallax/v1/jobs.pb.h"
#include "worker/dataset/frame/render_job.h"
#include "worker/jobs/files/finished_frames.h"
#include "worker/jobs/jobs.h"

namespace parallax {
namespace {

absl::StatusOr<std::vector<OutputFile>> FilesOf(const v1::RenderResult& result,
                                                const std::string& attempt_path,
                                                const FinishedFrames& finished) {
  std::vector<OutputFile> files;
  for (const v1::FrameResult& frame : result.frames()) {
    if (frame.path().rfind(attempt_path + "/", 0) != 0) {
      return Internal("frame {} is not below its attempt's {}", frame.path(), attempt_path);
    }
    const std::string folder = frame.path().substr(attempt_path.size() + 1);  // "003"
    for (const v1::FileEntry& file : frame.files()) {
      files.push_back({folder + "/" + file.name(), file.size(), file.sha256(),
                       /*sent=*/finished.IsSent(frame.rig())});
    }
  }
  return files;
}

// The frames that earlier attempts have not finished, rendered, and those that they have.
absl::StatusOr<v1::RenderResult> RenderTheRest(const v1::RenderJob& job,
                                               const AttemptFolder& folder,
                                               FinishedFrames& finished, const CancelToken& cancel,
                                               const JobProgressFn& progress) {
  ASSIGN_OR_RETURN(const std::vector<v1::FrameResult> taken, finished.TakeOver(job, cancel));
  std::set<uint32_t> there;
  for (const v1::FrameResult& frame : taken) there.insert(frame.rig());
  v1::RenderJob rest = job;
  rest.clear_rigs();
  for (const uint32_t rig : job.rigs()) {
    if (there.count(rig) == 0) rest.add_rigs(rig);
  }
  const double begin =
      static_cast<double>(taken.size()) / static_cast<double>(std::max(1, job.rigs_size()));
  RenderJobContext context;
  context.attempt_dir = folder.dir;
  context.attempt_path = folder.path;
  context.cancel = cancel;
  context.progress = [&progress, begin](double fraction) {
    progress(begin + (1 - begin) * fraction, "render");
  };
  // A job of one pair that ends early has nothing to keep.
  if (job.rigs_size() > 1) {
    context.finished = [&finished](const v1::FrameResult& frame) { finished.Note(frame); };
  }
  v1::RenderResult result;
  if (taken.empty() || rest.rigs_size() > 0) {
    progress(begin, "build");
    ASSIGN_OR_RETURN(result, RunRenderJob(rest, context));
  }
  for (const v1::FrameResult& frame : taken) *result.add_frames() = frame;
  std::sort(result.mutable_frames()->begin(), result.mutable_frames()->end(),
            [](const v1::FrameResult& a, const v1::FrameResult& b) { return a.rig() < b.rig(); });
  return result;
}

class RenderHandler final : public JobHandler {
 public:
  explicit RenderHandler(std::shared_ptr<const JobOptions> options)
      : JobHandler("render", /*writes_output=*/true, /*resumes=*/true),
        options_(std::move(options)) {}

  absl::StatusOr<JobOutcome> Run(std::string_view spec, const AttemptFolder& folder,
                                 const CancelToken& cancel,
                                 const JobProgressFn& progress) override {
    v1::RenderJob job;
    if (!job.ParseFromArray(spec.data(), static_cast<int>(spec.size()))) {
      return InvalidArgument("a spec that is no RenderJob");
    }
    if (folder.store != nullptr) {
      RETURN_IF_ERROR(BringContent(ContentCache(options_->content_cache), *folder.store,
                                   {cancel, [&progress] { progress(0, "content"); }}, job));
    }
    FinishedFrames finished(folder);
    const auto result = RenderTheRest(job, folder, finished, cancel, progress);
    if (!result.ok()) {
      finished.RemoveUnfinished();
      return result.status();
    }
    // The notes stay: until the coordinator has the result, another attempt may need them.
    JobOutcome outcome;
    ASSIGN_OR_RETURN(outcome.files, FilesOf(*result, folder.path, finished));
    outcome.result = result->SerializeAsString();
    return outcome;
  }

 private:
  const std::shared_ptr<const JobOptions> options_;
};

}  // namespace

std::unique_ptr<JobHandler> MakeRenderHandler(std::shared_ptr<const JobOptions> options) {
  return std::make_unique<RenderHandler>(std::move(options));
}

}  // namespace parallax
