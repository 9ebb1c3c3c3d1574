// The worker program with jobs that only take time: PARALLAX_NOOP_MS milliseconds each.
#include <cstdlib>
#include <thread>

#include "tests/worker/agent/noop_runner.h"
#include "worker/agent/worker_program.h"

namespace parallax {
namespace {

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

 private:
  static void Dawdle(const CancelToken& cancel) {
    const char* text = std::getenv("PARALLAX_NOOP_MS");
    for (int left = text == nullptr ? 0 : std::atoi(text); left > 0 && !cancel.cancelled();
         --left) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
};

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  static parallax::SlowNoopRunner runner;
  return parallax::RunWorkerProgram(argc, argv, parallax::HandlersOf(runner));
}
