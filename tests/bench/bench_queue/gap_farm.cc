#include "gap_farm.h"

#include <condition_variable>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "common/base/rng.h"
#include "common/base/system/clock.h"
#include "no_op.h"
#include "samples.h"
#include "tests/job_messages.h"
#include "tests/worker/agent/test_runner.h"
#include "worker/agent/agent.h"

namespace parallax {
namespace {

// Waits as long as a job takes; notes when each slot (a thread of the agent) was idle.
class WaitingRunner final : public TestRunner {
 public:
  WaitingRunner(int number, double job_s, const std::atomic<bool>& counting, Samples& gaps_ms)
      : number_(number), job_s_(job_s), counting_(counting), gaps_ms_(gaps_ms) {}

  absl::StatusOr<v1::SolveResult> Solve(const v1::SolveJob& job, const CancelToken& cancel,
                                        const JobProgressFn& progress) override {
    Begin();
    Wait(cancel, progress);
    v1::Lease lease;
    lease.set_kind("solve");
    lease.set_spec(job.SerializeAsString());
    const v1::SolveResult result = SolveOf(NoOpAnswer(lease, ""));
    End();
    return result;
  }

  absl::StatusOr<v1::RenderResult> Render(const v1::RenderJob& job, const AttemptFolder& folder,
                                          const CancelToken& cancel,
                                          const JobProgressFn& progress) override {
    Begin();
    Wait(cancel, progress);
    v1::RenderResult result;
    for (const uint32_t rig : job.rigs()) *result.add_frames() = NoOpFrame(job, rig, folder.path);
    End();
    return result;
  }

 private:
  void Begin() {
    const std::lock_guard lock(mutex_);
    const auto ended = ended_.find(std::this_thread::get_id());
    if (counting_ && ended != ended_.end()) gaps_ms_.Add(1000 * SecondsSince(ended->second));
  }
  void End() {
    const std::lock_guard lock(mutex_);
    ended_[std::this_thread::get_id()] = BenchClock::now();
  }
  void Wait(const CancelToken& cancel, const JobProgressFn& progress) {
    constexpr int kSteps = 10;
    Rng rng = Rng(SceneSeed{static_cast<uint64_t>(number_)}, "bench/job").Child("job", jobs_++);
    const double seconds = job_s_ * (0.5 + rng.Uniform());
    for (int i = 0; i < kSteps && !cancel.cancelled(); ++i) {
      std::this_thread::sleep_for(std::chrono::duration<double>(seconds / kSteps));
      progress(static_cast<double>(i + 1) / kSteps, "wait");
    }
  }

  const int number_;
  const double job_s_;
  const std::atomic<bool>& counting_;
  Samples& gaps_ms_;
  std::atomic<uint64_t> jobs_{0};
  std::mutex mutex_;
  std::map<std::thread::id, BenchClock::time_point> ended_;  // Guarded by mutex_.
};

}  // namespace

absl::StatusOr<GapFigures> MeasureGaps(const GapOptions& options) {
  ASSIGN_OR_RETURN(const RpcAddress address, ParseRpcAddress(options.address));
  Samples gaps_ms;
  std::atomic<bool> counting = false;
  std::vector<std::unique_ptr<WaitingRunner>> runners;
  std::vector<std::unique_ptr<JobHandlers>> handlers;
  std::vector<std::unique_ptr<Agent>> agents;
  for (int i = 0; i < options.workers; ++i) {
    AgentOptions agent;
    agent.coordinator = address;
    agent.name = "gap-" + std::to_string(i);
    agent.kinds = {"solve", "render"};
    agent.memory_mb = 1024;
    agent.outbox_root = options.outbox_root + "/" + std::to_string(i);
    agent.grace_s = 0.1;
    agent.hand_back_s = 1;
    runners.push_back(std::make_unique<WaitingRunner>(i, options.job_s, counting, gaps_ms));
    handlers.push_back(std::make_unique<JobHandlers>(HandlersOf(*runners.back())));
    ASSIGN_OR_RETURN(auto made, Agent::Create(agent, *handlers.back(), Clock::System()));
    agents.push_back(std::move(made));
  }
  std::vector<std::thread> threads;
  for (const auto& agent : agents) {
    threads.emplace_back([&agent] { agent->Run().status().IgnoreError(); });
  }
  // Waits until the first jobs of all workers have begun.
  std::this_thread::sleep_for(std::chrono::duration<double>(2 + 2 * options.job_s));
  counting = true;
  std::this_thread::sleep_for(std::chrono::duration<double>(options.seconds));
  counting = false;
  for (const auto& agent : agents) agent->Drain();
  for (std::thread& thread : threads) thread.join();
  return GapFigures{static_cast<int64_t>(gaps_ms.count()), gaps_ms.Percentile(0.5),
                    gaps_ms.Percentile(0.99)};
}

}  // namespace parallax
