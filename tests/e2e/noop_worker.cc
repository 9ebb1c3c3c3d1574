// The worker program with jobs that only take time: PARALLAX_NOOP_MS milliseconds each. With
// PARALLAX_NOOP_KIND it takes jobs of the kind `noop` as well, which only the coordinator of tests
// knows.
#include <cstdlib>
#include <thread>

#include "common/base/status.h"
#include "tests/noop/noop_handler.h"
#include "tests/worker/agent/noop_runner.h"
#include "worker/agent/worker_program.h"

namespace parallax {
namespace {

void Dawdle(const CancelToken& cancel) {
  const char* text = std::getenv("PARALLAX_NOOP_MS");
  for (int left = text == nullptr ? 0 : std::atoi(text); left > 0 && !cancel.cancelled(); --left) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

class SlowNoopRunner final : public NoopRunner {
 public:
  absl::StatusOr<v1::SolveResult> Solve(const v1::SolveJob& job, const CancelToken& cancel,
                                        const JobProgressFn& progress) override {
    Dawdle(cancel);
    return NoopRunner::Solve(job, cancel, progress);
  }
  absl::StatusOr<v1::RenderResult> Render(const v1::RenderJob& job, const AttemptFolder& folder,
                                          const CancelToken& cancel,
                                          const JobProgressFn& progress) override {
    Dawdle(cancel);
    return NoopRunner::Render(job, folder, cancel, progress);
  }
};

class SlowNoopHandler final : public NoopHandler {
 public:
  absl::StatusOr<JobOutcome> Run(std::string_view spec, const AttemptFolder& folder,
                                 const CancelToken& cancel,
                                 const JobProgressFn& progress) override {
    Dawdle(cancel);
    if (cancel.cancelled()) return Cancelled("cancelled");
    return NoopHandler::Run(spec, folder, cancel, progress);
  }
};

int Main(int argc, char** argv) {
  static SlowNoopRunner runner;
  JobHandlers handlers = HandlersOf(runner);
  if (std::getenv("PARALLAX_NOOP_KIND") != nullptr) {
    handlers.push_back(std::make_unique<SlowNoopHandler>());
  }
  return RunWorkerProgram(argc, argv, std::move(handlers));
}

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) { return parallax::Main(argc, argv); }
