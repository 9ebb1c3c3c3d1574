// Experiment 5, second part: the wall clocks of coordinator and workers jump by up to an hour, each
// by itself, while jobs fail, back off and are leased. Everything is real but the clocks, so it all
// runs in this process.
#include <thread>

#include "common/base/status.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/coordinator_server.h"
#include "tests/coordinator/queue/queue_fixture.h"
#include "tests/faults/experiment.h"
#include "tests/faults/farm.h"
#include "tests/worker/agent/noop_runner.h"
#include "worker/agent/agent.h"

namespace parallax::faults {
namespace {

constexpr int kWorkers = 3;

class JumpyClock final : public Clock {
 public:
  double UnixSeconds() override { return Clock::System().UnixSeconds() + offset_s_; }
  SteadyTime Steady() override { return Clock::System().Steady(); }
  void JumpTo(double offset_s) { offset_s_ = offset_s; }

 private:
  std::atomic<double> offset_s_{0};
};

// Fails each job's first attempt here, so that back-offs are under way when clocks jump.
class StumblingRunner final : public NoopRunner {
 public:
  absl::StatusOr<v1::RenderResult> Render(const v1::RenderJob& job, const AttemptFolder& folder,
                                          const CancelToken& cancel,
                                          const JobProgressFn& progress) override {
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
    {
      const std::lock_guard lock(mu_);
      // One worker's stumble and no other's: equal failures of two would be a verdict.
      if (job.scene().scene_seed() % 2 == 0 && stumbled_.insert(job.scene().scene_seed()).second) {
        return Unavailable("stumbled over {}", job.scene().scene_seed());
      }
    }
    return NoopRunner::Render(job, folder, cancel, progress);
  }

 private:
  std::mutex mu_;
  std::set<uint64_t> stumbled_;
};

}  // namespace

void ClockJumps(const ExperimentOptions& options, Tally& tally) {
  for (int round = 0; round < options.rounds; ++round) {
    Rng rng = RoundRng(options, "clock-jumps", round);
    const TempFolder folder(true);
    JumpyClock clock;
    JobQueueOptions queue_options;
    queue_options.db_path = folder.path() + "/queue.db";
    queue_options.clock = &clock;
    queue_options.lease_s = 2;
    queue_options.retry.backoff_min_s = 0.05;
    queue_options.retry.backoff_max_s = 0.5;
    auto queue = JobQueue::Open(queue_options);
    if (!queue.ok()) return tally.Lost(queue.status().ToString());
    CoordinatorServerOptions server_options;
    server_options.listen = {"127.0.0.1:0"};
    server_options.store_uri = "file://" + folder.path() + "/store";
    server_options.clock = &clock;
    auto server = CoordinatorServer::Start(server_options, **queue);
    if (!server.ok()) return tally.Lost(server.status().ToString());

    const int64_t pairs = 300;
    const auto submitted =
        (*queue)->Submit(MakeStudy({.seed = rng.Bits32(), .pairs = pairs}), "faults");
    if (!submitted.ok()) return tally.Lost(submitted.status().ToString());
    const StudyId study{submitted->study_id()};

    StumblingRunner runner;
    const JobHandlers handlers = HandlersOf(runner);
    std::vector<std::unique_ptr<JumpyClock>> clocks;
    std::vector<std::unique_ptr<Agent>> agents;
    std::vector<std::thread> threads;
    for (int i = 0; i < kWorkers; ++i) {
      clocks.push_back(std::make_unique<JumpyClock>());
      AgentOptions agent;
      agent.coordinator = *ParseRpcAddress((*server)->addresses()[0]);
      agent.name = "w" + std::to_string(i);
      agent.kinds = {"solve", "render"};
      agent.outbox_root = folder.path() + "/outbox";
      agents.push_back(*Agent::Create(agent, handlers, *clocks.back()));
      threads.emplace_back([agent = agents.back().get()] {
        const auto summary = agent->Run();
        if (!summary.ok()) std::fprintf(stderr, "%s\n", summary.status().ToString().c_str());
      });
    }
    const auto begin = std::chrono::steady_clock::now();
    v1::StudyStatus status;
    bool ended = false;
    while (!ended && SecondsSince(begin) < 60) {
      Sleep(rng.Uniform(0.002, 0.03));
      const double jump_s = rng.Uniform(-3600, 3600);
      const int whose = rng.UniformInt(0, kWorkers);
      (whose == kWorkers ? clock : *clocks[static_cast<size_t>(whose)]).JumpTo(jump_s);
      ++tally.faults;
      const auto now = (*queue)->GetStudy(study);
      if (!now.ok()) return tally.Lost(now.status().ToString());
      status = *now;
      ended = status.state() == v1::STUDY_STATE_SUCCEEDED;
    }
    for (const auto& agent : agents) agent->Drain();
    for (std::thread& thread : threads) thread.join();
    if (!ended) tally.Lost("the study does not end: " + status.ShortDebugString());
    const JobQueueStats stats = (*queue)->Stats();
    if (stats.losses > 0) {
      tally.Lost(std::to_string(stats.losses) + " leases were lost to a jump of the clock");
    }
    tally.figures["back_offs"] += static_cast<double>(stats.failures);
    tally.jobs += static_cast<int64_t>(stats.completions);
    const auto violations = (*queue)->Check();
    tally.Found(
        violations.ok() ? *violations : std::vector<std::string>{violations.status().ToString()},
        "clock-jumps, round " + std::to_string(round));
    ++tally.rounds;
  }
}

}  // namespace parallax::faults
