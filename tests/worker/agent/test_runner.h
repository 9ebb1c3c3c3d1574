// Handlers of the two kinds of jobs that call one object, with the messages parsed.
#pragma once

#include "common/base/status.h"
#include "parallax/v1/jobs.pb.h"
#include "worker/agent/attempts/job_handler.h"

namespace parallax {

class TestRunner {
 public:
  virtual ~TestRunner() = default;
  virtual absl::StatusOr<v1::SolveResult> Solve(const v1::SolveJob& job, const CancelToken& cancel,
                                                const JobProgressFn& progress) = 0;
  virtual absl::StatusOr<v1::RenderResult> Render(const v1::RenderJob& job,
                                                  const AttemptFolder& folder,
                                                  const CancelToken& cancel,
                                                  const JobProgressFn& progress) = 0;
};

class TestSolveHandler final : public JobHandler {
 public:
  explicit TestSolveHandler(TestRunner& runner)
      : JobHandler("solve", /*writes_output=*/false), runner_(runner) {}
  absl::StatusOr<JobOutcome> Run(std::string_view spec, const AttemptFolder&,
                                 const CancelToken& cancel,
                                 const JobProgressFn& progress) override {
    v1::SolveJob job;
    if (!job.ParseFromString(std::string(spec))) return InvalidArgument("no SolveJob");
    ASSIGN_OR_RETURN(const v1::SolveResult result, runner_.Solve(job, cancel, progress));
    return JobOutcome{result.SerializeAsString(), {}};
  }

 private:
  TestRunner& runner_;
};

class TestRenderHandler final : public JobHandler {
 public:
  explicit TestRenderHandler(TestRunner& runner)
      : JobHandler("render", /*writes_output=*/true), runner_(runner) {}
  absl::StatusOr<JobOutcome> Run(std::string_view spec, const AttemptFolder& folder,
                                 const CancelToken& cancel,
                                 const JobProgressFn& progress) override {
    v1::RenderJob job;
    if (!job.ParseFromString(std::string(spec))) return InvalidArgument("no RenderJob");
    ASSIGN_OR_RETURN(const v1::RenderResult result, runner_.Render(job, folder, cancel, progress));
    JobOutcome outcome{result.SerializeAsString(), {}};
    for (const v1::FrameResult& frame : result.frames()) {
      for (const v1::FileEntry& file : frame.files()) {
        outcome.files.push_back({frame.path().substr(folder.path.size() + 1) + "/" + file.name(),
                                 file.size(), file.sha256()});
      }
    }
    return outcome;
  }

 private:
  TestRunner& runner_;
};

// `runner` outlives the handlers.
inline JobHandlers HandlersOf(TestRunner& runner) {
  JobHandlers handlers;
  handlers.push_back(std::make_unique<TestSolveHandler>(runner));
  handlers.push_back(std::make_unique<TestRenderHandler>(runner));
  return handlers;
}

}  // namespace parallax
