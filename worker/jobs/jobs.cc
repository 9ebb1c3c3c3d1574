#include "worker/jobs/jobs.h"

namespace parallax {
namespace {

// Lets a job whose threads are the whole worker's wait while others have all cores alone.
class SharingHandler final : public JobHandler {
 public:
  SharingHandler(std::unique_ptr<JobHandler> handler, std::shared_ptr<const JobOptions> options)
      : JobHandler(handler->kind(), handler->writes_output(), handler->resumes()),
        handler_(std::move(handler)),
        options_(std::move(options)) {}

  absl::StatusOr<JobOutcome> Run(std::string_view spec, const AttemptFolder& folder,
                                 const CancelToken& cancel,
                                 const JobProgressFn& progress) override {
    CoreShare::Hold core;
    if (options_->cores != nullptr) {
      ASSIGN_OR_RETURN(core, options_->cores->TakeShared(
                                 cancel, [&progress] { progress(0, "wait for cores"); }));
    }
    return handler_->Run(spec, folder, cancel, progress);
  }

 private:
  const std::unique_ptr<JobHandler> handler_;
  const std::shared_ptr<const JobOptions> options_;
};

}  // namespace

JobHandlers MakeJobHandlers(std::shared_ptr<const JobOptions> options) {
  JobHandlers handlers;
  handlers.push_back(std::make_unique<SharingHandler>(MakeSolveHandler(), options));
  handlers.push_back(std::make_unique<SharingHandler>(MakeRenderHandler(), options));
  handlers.push_back(MakeTrainHandler(options));
  handlers.push_back(MakeEvaluateHandler(options));
  return handlers;
}

}  // namespace parallax
