#include "worker/jobs/sharing_handler.h"

namespace parallax {
namespace {

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

std::unique_ptr<JobHandler> ShareCores(std::unique_ptr<JobHandler> handler,
                                       std::shared_ptr<const JobOptions> options) {
  return std::make_unique<SharingHandler>(std::move(handler), std::move(options));
}

}  // namespace parallax
