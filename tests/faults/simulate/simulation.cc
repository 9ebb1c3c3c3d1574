#include "tests/faults/simulate/simulation.h"

#include <malloc.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "tests/faults/experiment.h"
#include "tests/faults/simulate/coordinator.h"
#include "tests/faults/simulate/exact_math.h"
#include "tests/faults/simulate/users/client.h"
#include "tests/faults/simulate/users/consumer.h"
#include "tests/faults/simulate/users/searcher.h"
#include "tests/faults/simulate/worker.h"

namespace parallax::faults {

double World::Next(double mean_s) { return mean_s * -Log(1 - dice.Uniform()); }

StageVersions World::VersionsOf(int release) {
  StageVersions versions;
  if (release > 0) versions.frame = "next";
  return versions;
}

namespace {

class Run {
 public:
  explicit Run(const RunOptions& options)
      : folder_(/*memory=*/true),
        events_(options.events),
        world_(options.seed, options.tells, options.mutation, options.events > 0),
        coordinator_(world_, folder_.path()) {
    std::vector<std::string> names;
    for (int i = 0; i < world_.knobs.workers; ++i) {
      workers_.push_back(std::make_unique<SimWorker>(world_, coordinator_, folder_.path(), i));
      names.push_back(workers_.back()->name());
    }
    client_ = std::make_unique<SimClient>(world_, coordinator_, names);
    if (world_.knobs.has_stream) {
      consumer_ = std::make_unique<SimConsumer>(world_, coordinator_, *client_);
    }
    if (world_.knobs.has_search) {
      searcher_ = std::make_unique<SimSearcher>(world_, coordinator_, *client_, folder_.path());
    }
  }

  ~Run() { coordinator_.End(); }  // Before the workers, who have its streams' lines.

  RunResult Live() {
    coordinator_.Start();
    client_->Start();
    if (consumer_ != nullptr) consumer_->Start();
    if (searcher_ != nullptr) searcher_->Start();
    if (world_.knobs.upgrade_at_s > 0) {
      world_.schedule.After(world_.knobs.upgrade_at_s, [this] { Upgrade(); });
    }
    if (world_.knobs.store_lie_every_s > 0 && world_.knobs.has_files) LieLater();
    if (world_.knobs.crash_loop_at_s > 0) {
      world_.schedule.After(world_.knobs.crash_loop_at_s, [this] { BeginCrashLoop(); });
    }
    for (const auto& worker : workers_) {
      world_.schedule.After(world_.Next(world_.knobs.worker_away_s),
                            [&worker] { worker->Start(); });
    }
    if (events_ == 0) RunUntil(world_.knobs.faults_s);
    while (goes_on() && world_.schedule.events() < events_) RunUntil(In(1));
    if (world_.knobs.upgrade_at_s > 0) Upgrade(/*at_once=*/true);
    world_.story.Tell("the faults are over");
    world_.has_faults = false;
    coordinator_.Mend();
    for (const auto& worker : workers_) worker->Mend();
    client_->Settle();
    ComeToRest();
    const double grown_bytes = events_ > 0 ? MeasureGrowth() : 0;
    if (sound() && !coordinator_.has_refused()) Judge();
    return {.complaints = coordinator_.model().complaints(),
            .story = world_.story.text(),
            .virtual_s = world_.schedule.now(),
            .events = world_.schedule.events(),
            .jobs = coordinator_.model().done(),
            .stale = coordinator_.model().stale(),
            .starts = coordinator_.lives(),
            .refused = coordinator_.has_refused(),
            .points = coordinator_.points(),
            .grown_bytes = grown_bytes,
            .database_bytes = static_cast<double>(
                events_ > 0 ? std::filesystem::file_size(folder_.path() + "/queue.db") : 0)};
  }

 private:
  // The time after so many leases.
  double In(double leases) const {
    return world_.schedule.now() + leases * world_.knobs.queue.lease_s;
  }

  void ComeToRest() {
    const double bound_s = world_.schedule.now() + Bound();
    while (goes_on() && !HasEnded() && world_.schedule.now() < bound_s) RunUntil(In(1));
  }

  // All processes begin anew: what they hold less than before had grown.
  double MeasureGrowth() {
    const auto held_bytes = [] {
      const struct mallinfo2 heap = mallinfo2();
      return static_cast<double>(heap.uordblks + heap.hblkhd);
    };
    RunUntil(In(2));
    const double before = held_bytes();
    if (coordinator_.is_up()) coordinator_.Die(/*power_cut=*/false);
    for (const auto& worker : workers_) {
      if (worker->is_up()) worker->Die("ends", world_.knobs.turn_s);
    }
    ComeToRest();
    RunUntil(In(2));
    return before - held_bytes();
  }

  void LieLater() {
    world_.schedule.After(world_.Next(world_.knobs.store_lie_every_s), [this] {
      if (!world_.has_faults) return;
      world_.story.Tell("the store: {}", coordinator_.disk().Lie(world_.dice));
      LieLater();
    });
  }

  // As soon as a worker has a report without an answer, unless it is to be at once. The worker
  // comes back soon, mostly with the same release as the coordinator.
  void Upgrade(bool at_once = false) {
    if (world_.upgraded || !goes_on()) return;
    const double lease_s = world_.knobs.queue.lease_s;
    const auto reports = std::find_if(workers_.begin(), workers_.end(), [](const auto& worker) {
      return worker->is_up() && worker->pending() > 0;
    });
    if (reports == workers_.end() && !at_once) {
      return world_.schedule.After(lease_s / 100, [this] { Upgrade(); });
    }
    world_.upgraded = true;
    world_.story.Tell("the coordinator's machine has the next release");
    if (reports != workers_.end()) (*reports)->Die("is killed, with its coordinator", lease_s / 10);
    if (coordinator_.is_up()) coordinator_.Die(/*power_cut=*/false);
  }

  // As soon as a worker has jobs that may go on.
  void BeginCrashLoop() {
    if (!world_.has_faults) return;
    const double lease_s = world_.knobs.queue.lease_s;
    for (const auto& worker : workers_) {
      const std::vector<v1::AttemptId> attempts = worker->running();
      if (attempts.empty() || !coordinator_.is_up()) continue;
      worker->Die("is killed, with its coordinator", 5 * lease_s);
      return coordinator_.BeginCrashLoop(worker->name(), attempts);
    }
    world_.schedule.After(lease_s / 10, [this] { BeginCrashLoop(); });
  }

  bool sound() { return coordinator_.model().complaints().empty(); }
  bool goes_on() { return sound() && !coordinator_.has_refused(); }

  void RunUntil(double until_s) {
    while (goes_on() && world_.schedule.RunNext(until_s)) continue;
  }

  // By then everything has ended, however unlucky it is: a sole worker does all jobs one after
  // another, all with their longest back-offs, after the longest suspension of workers.
  double Bound() const {
    constexpr double kLongestSuspension_s = 3600;
    constexpr double kMostJobs = 300;
    const Knobs& knobs = world_.knobs;
    return 200 * knobs.queue.lease_s + kMostJobs * 5 * knobs.job_s + kLongestSuspension_s +
           10 * knobs.queue.retry.backoff_max_s * knobs.queue.retry.max_app_failures;
  }

  bool HasEnded() {
    if (!coordinator_.is_up() || !client_->is_done()) return false;
    if (consumer_ != nullptr && !consumer_->is_done()) return false;
    if (searcher_ != nullptr && !searcher_->is_done()) return false;
    for (const auto& worker : workers_) {
      if (worker->pending() > 0) return false;
    }
    const auto open = coordinator_.queue().ListStudies(1, 0, /*only_unfinished=*/true);
    return open.ok() && open->empty() && coordinator_.WrongFile().empty() &&
           coordinator_.UntoldStudy().empty();
  }

  void Judge() {
    QueueModel& model = coordinator_.model();
    if (!client_->is_done()) model.Complain("the clients' calls are not answered");
    if (consumer_ != nullptr && !consumer_->is_done()) {
      model.Complain("a stream has not delivered its pairs, or is not gone after its end");
    }
    if (searcher_ != nullptr && !searcher_->is_done()) {
      model.Complain("a search does not end, or is not gone after it");
    }
    for (const auto& worker : workers_) {
      if (worker->pending() > 0) {
        model.Complain(worker->name() + " has reports that are not answered");
      }
    }
    if (!coordinator_.is_up()) return model.Complain("the coordinator is not up");
    if (const std::string file = coordinator_.WrongFile(); !file.empty()) {
      model.Complain(file + " is published, and is not in the store as it was put there");
    }
    if (const std::string study = coordinator_.UntoldStudy(); !study.empty()) {
      model.Complain("the operator was not told of the end of " + study);
    }
    model.Compare(coordinator_.queue(), /*at_end=*/true);
  }

  const TempFolder folder_;
  const int64_t events_;
  World world_;
  SimCoordinator coordinator_;
  std::vector<std::unique_ptr<SimWorker>> workers_;
  std::unique_ptr<SimClient> client_;
  std::unique_ptr<SimConsumer> consumer_;
  std::unique_ptr<SimSearcher> searcher_;
};

}  // namespace

RunResult RunSeed(const RunOptions& options) { return Run(options).Live(); }

}  // namespace parallax::faults
