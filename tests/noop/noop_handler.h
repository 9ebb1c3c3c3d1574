// Kind `noop`, the worker's side: hands the spec back.
#pragma once

#include "worker/agent/attempts/job_handler.h"

namespace parallax {

class NoopHandler : public JobHandler {
 public:
  NoopHandler() : JobHandler("noop", /*writes_output=*/false) {}
  absl::StatusOr<JobOutcome> Run(std::string_view spec, const AttemptFolder&, const CancelToken&,
                                 const JobProgressFn& progress) override {
    progress(1, "noop");
    return JobOutcome{std::string(spec), {}};
  }
};

}  // namespace parallax
