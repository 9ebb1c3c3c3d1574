// Experiment 7: among many jobs one crashes its worker, one hangs, one eats all memory, and one
// worker fails everything it touches.
#include <signal.h>

#include <thread>

#include "coordinator/study/keys.h"
#include "tests/faults/farm.h"

namespace parallax::faults {
namespace {

// Starts a worker again when it ends, as systemd or Kubernetes does.
class Supervised {
 public:
  Supervised(Farm& farm, std::string name, std::vector<std::string> environment)
      : farm_(farm), name_(std::move(name)), environment_(std::move(environment)) {
    Start();
  }
  void Watch() {
    if (worker_->Running()) return;
    ++restarts_;
    Start();
  }
  Process& process() { return *worker_; }
  int restarts() const { return restarts_; }

 private:
  void Start() {
    worker_ = farm_.StartWorker(name_, 0, "", environment_, 2, PARALLAX_POISON_WORKER_PROGRAM,
                                {"--hang-s", "1.5"});
  }

  Farm& farm_;
  const std::string name_;
  const std::vector<std::string> environment_;
  std::unique_ptr<Process> worker_;
  int restarts_ = 0;
};

}  // namespace

void Poison(const ExperimentOptions& options, Tally& tally) {
  for (int round = 0; round < options.rounds; ++round) {
    Rng rng = RoundRng(options, "poison", round);
    // Short back-offs: most of a round would be spent in them.
    Farm farm({.lease_s = 3, .reconnect_s = 0.2, .backoff_s = 0.3});
    farm.StartCoordinator();
    const int64_t jobs = options.jobs > 0 ? options.jobs : 400;
    const StudyShape shape{.seed = rng.Bits32(), .pairs = jobs / 2, .rigs_per_scene = 1};
    std::vector<uint32_t> scenes(static_cast<size_t>(shape.pairs));
    for (size_t i = 0; i < scenes.size(); ++i) scenes[i] = static_cast<uint32_t>(i);
    rng.Shuffle(scenes);
    const auto seed = [&](int i) {
      return std::to_string(SceneSeedOf(shape.seed, scenes[static_cast<size_t>(i)]).value);
    };
    const std::string poison =
        "PARALLAX_POISON=crash:" + seed(0) + ",hang:" + seed(1) + ",eat:" + seed(2);
    const int64_t study = farm.Submit(shape);
    std::vector<std::unique_ptr<Supervised>> workers;
    for (int i = 0; i < 4; ++i) {
      std::vector<std::string> environment{poison};
      if (i == 3) environment.push_back("PARALLAX_FAIL_ALL=1");
      workers.push_back(
          std::make_unique<Supervised>(farm, "w" + std::to_string(i), std::move(environment)));
    }
    tally.faults += 4;
    const bool ended = farm.WaitFor(
        study,
        [&](const v1::StudyStatus& status) {
          for (const auto& worker : workers) worker->Watch();
          return status.state() == v1::STUDY_STATE_SUCCEEDED;
        },
        120 + static_cast<double>(jobs) / 20);
    if (!ended) tally.Lost("the study does not end: " + farm.Status(study).ShortDebugString());

    // The three poisonous ones are quarantined, nothing else is; each pair asked for is there.
    v1::ListJobsRequest request;
    request.set_study_id(study);
    request.set_state("QUARANTINED");
    int64_t quarantined = 0;
    for (const v1::JobStatus& job : farm.Jobs(request)) {
      const bool poisonous =
          job.scene() == scenes[0] || job.scene() == scenes[1] || job.scene() == scenes[2];
      ++quarantined;
      if (!poisonous) tally.Lost("good scene " + std::to_string(job.scene()) + ": " + job.error());
    }
    request.set_state("FAILED");
    for (const v1::JobStatus& job : farm.Jobs(request)) {
      tally.Lost("job " + std::to_string(job.job_id()) + " failed: " + job.error());
    }
    if (quarantined != 3) {
      tally.Lost(std::to_string(quarantined) + " jobs are quarantined, not the 3 poisonous ones");
    }
    for (const auto& worker : workers) {
      tally.figures["worker_restarts"] += worker->restarts();
      worker->process().Signal(SIGTERM);
      worker->process().Wait(Process::Seconds(20));
    }
    tally.figures["quarantined"] += static_cast<double>(quarantined);
    farm.CheckPairs(study, static_cast<size_t>(shape.pairs), tally);
    farm.StopAndAudit(tally, "poison, round " + std::to_string(round));
    ++tally.rounds;
  }
}

}  // namespace parallax::faults
