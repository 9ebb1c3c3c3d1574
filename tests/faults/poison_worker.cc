// The worker program with jobs that only take time, some of which are poisonous. By environment:
//   PARALLAX_POISON=crash:SEED,hang:SEED,eat:SEED   what rendering the scene of that seed does
//   PARALLAX_FAIL_ALL=1                             this machine is broken: everything fails on it
#include <sys/resource.h>

#include <chrono>
#include <cstdlib>
#include <sstream>
#include <thread>

#include "common/base/status.h"
#include "tests/worker/agent/noop_runner.h"
#include "worker/agent/worker_program.h"

namespace parallax {
namespace {

constexpr size_t kMemoryBytes = size_t{6} << 30;  // Address space that this worker may have.

class PoisonRunner final : public NoopRunner {
 public:
  PoisonRunner() : broken_(std::getenv("PARALLAX_FAIL_ALL") != nullptr) {
    const char* text = std::getenv("PARALLAX_POISON");
    std::stringstream items(text == nullptr ? "" : text);
    for (std::string item; std::getline(items, item, ',');) {
      const size_t colon = item.find(':');
      if (colon == std::string::npos) continue;
      poison_[std::strtoull(item.c_str() + colon + 1, nullptr, 10)] = item.substr(0, colon);
    }
  }

  absl::StatusOr<v1::SolveResult> Solve(const v1::SolveJob& job, const CancelToken& cancel,
                                        const JobProgressFn& progress) override {
    if (broken_) return Internal("this machine is broken");
    return NoopRunner::Solve(job, cancel, progress);
  }

  absl::StatusOr<v1::RenderResult> Render(const v1::RenderJob& job, const AttemptFolder& folder,
                                          const CancelToken& cancel,
                                          const JobProgressFn& progress) override {
    if (broken_) return Internal("this machine is broken");
    const auto found = poison_.find(job.scene().scene_seed());
    if (found != poison_.end()) {
      if (found->second == "crash") std::abort();
      if (found->second == "hang") {
        while (true) std::this_thread::sleep_for(std::chrono::seconds(1));
      }
      if (found->second == "eat") Eat();
    }
    return NoopRunner::Render(job, folder, cancel, progress);
  }

 private:
  // Allocates until there is no more memory; ends with std::bad_alloc.
  static void Eat() {
    std::vector<std::unique_ptr<char[]>> eaten;
    while (true) eaten.push_back(std::make_unique<char[]>(size_t{64} << 20));
  }

  const bool broken_;
  std::map<uint64_t, std::string> poison_;
};

}  // namespace
}  // namespace parallax

int main(int argc, char** argv) {
  const rlimit limit{parallax::kMemoryBytes, parallax::kMemoryBytes};
  setrlimit(RLIMIT_AS, &limit);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  static parallax::PoisonRunner runner;
  return parallax::RunWorkerProgram(argc, argv, parallax::HandlersOf(runner));
}
