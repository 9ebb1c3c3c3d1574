// The part of experiment 10 for jobs that wait for others: noop jobs that wait for a study's pairs
// and for each other. Under kills, a zombie and lost replies the study has the same pairs and its
// noop jobs the same results as in peace: each began when all pairs were there, and was done once.
#include <signal.h>

#include <algorithm>

#include "coordinator/queue/database/database_file.h"
#include "tests/faults/farm.h"
#include "tests/faults/tcp_proxy.h"
#include "tests/job_messages.h"

namespace parallax::faults {
namespace {

constexpr int64_t kPairs = 24;
constexpr int kJob_ms = 120;
constexpr int kWorkers = 2;

struct Outcome {
  std::map<std::tuple<std::string, uint32_t, uint32_t>, std::map<std::string, std::string>> pairs;
  std::vector<std::string> results;  // Results of the noop jobs, sorted.
  bool operator==(const Outcome&) const = default;
};

std::vector<std::string> NoopResults(const std::string& db_path, Tally& tally) {
  std::vector<std::string> results;
  const auto db = OpenReader(db_path, "");
  if (!db.ok()) {
    tally.Lost("noop results: " + db.status().ToString());
    return results;
  }
  SqliteQuery query(**db, "SELECT bytes FROM results WHERE stage = 'noop' ORDER BY bytes");
  while (query.Next()) results.emplace_back(query.Blob(0));
  if (!query.status().ok()) tally.Lost("noop results: " + query.status().ToString());
  return results;
}

int64_t JobsDone(const v1::StudyStatus& status) {
  int64_t done = 0;
  for (const v1::VariantStatus& variant : status.variants()) {
    done += JobsOf(variant, "", "SUCCEEDED");
  }
  return done;
}

class WaitingFarm {
 public:
  WaitingFarm() : farm_({.lease_s = 2, .reconnect_s = 0.3}) {
    farm_.SetCoordinatorProgram(PARALLAX_NOOP_COORDINATOR_PROGRAM);
    farm_.StartCoordinator();
    study_ = farm_.Submit({.name = "waits", .pairs = kPairs, .rigs_per_scene = 2});
  }

  void StartWorkers(const std::string& address) {
    address_ = address;
    for (int i = 0; i < kWorkers; ++i) workers_.push_back(Worker(i));
  }
  // One fault: a worker is lost only after a job was done since the last loss, because a job that
  // loses three workers is quarantined.
  void Disturb(Rng& rng) {
    const auto i = static_cast<size_t>(rng.UniformInt(0, kWorkers - 1));
    const int64_t jobs = JobsDone(farm_.Status(study_));
    if (rng.Bernoulli(0.4)) {
      farm_.KillCoordinator();
      farm_.StartCoordinator();
    } else if (stopped_ < kWorkers) {
      Wake();
    } else if (jobs == jobs_at_loss_) {
      return;
    } else if (jobs_at_loss_ = jobs; rng.Bernoulli(0.5)) {
      stopped_ = i;
      workers_[i]->Signal(SIGSTOP);
    } else {
      workers_[i]->Signal(SIGKILL);
      workers_[i]->Wait();
      workers_[i] = Worker(static_cast<int>(i));
    }
    ++faults_;
  }
  void Wake() {
    if (stopped_ < kWorkers) workers_[stopped_]->Signal(SIGCONT);
    stopped_ = kWorkers;
  }
  bool Succeeded() { return farm_.Status(study_).state() == v1::STUDY_STATE_SUCCEEDED; }

  Outcome End(const std::string& where, Tally& tally) {
    Wake();
    if (!farm_.WaitForEnd(study_)) tally.Lost("the study with waits does not end, " + where);
    farm_.CheckPairs(study_, kPairs, tally);
    Outcome outcome;
    for (const auto& [key, frame] : farm_.Frames(study_, tally)) outcome.pairs[key] = frame.sha256;
    for (const auto& worker : workers_) {
      worker->Signal(SIGTERM);
      worker->Wait(Process::Seconds(20));
    }
    farm_.StopAndAudit(tally, where);
    outcome.results = NoopResults(farm_.folder() + "/queue.db", tally);
    tally.faults += faults_;
    return outcome;
  }
  const std::string& address() const { return farm_.address(); }

 private:
  std::unique_ptr<Process> Worker(int i) {
    return farm_.StartWorker("w" + std::to_string(i), kJob_ms, address_, {"PARALLAX_NOOP_KIND=1"});
  }

  Farm farm_;
  std::string address_;
  int64_t study_ = 0;
  std::vector<std::unique_ptr<Process>> workers_;
  size_t stopped_ = kWorkers;
  int64_t jobs_at_loss_ = 0;
  int64_t faults_ = 0;
};

Outcome CalmWaits(Tally& tally) {
  WaitingFarm farm;
  farm.StartWorkers("");
  return farm.End("waits in peace", tally);
}

Outcome ChaoticWaits(Rng rng, Tally& tally) {
  WaitingFarm farm;
  TcpProxy proxy(farm.address(), {.unary = 0.2, .stream = 0.05}, rng.Bits64());
  farm.StartWorkers(proxy.address());
  const auto begin = std::chrono::steady_clock::now();
  while (!farm.Succeeded() && SecondsSince(begin) < 60) {
    Sleep(rng.Uniform(0.1, 0.5));
    farm.Disturb(rng);
  }
  Outcome outcome = farm.End("waits under chaos", tally);
  tally.faults += proxy.counts().lost;
  return outcome;
}

}  // namespace

void InvarianceOfWaits(const ExperimentOptions& options, Tally& tally) {
  const Outcome calm = CalmWaits(tally);
  const std::string pairs = " of " + std::to_string(kPairs);
  if (calm.results != std::vector<std::string>{"waits/v again" + pairs, "waits/v" + pairs}) {
    tally.Lost("noop jobs in peace began before all pairs were there");
  }
  for (int round = 0; round < options.rounds; ++round) {
    const Outcome chaos = ChaoticWaits(RoundRng(options, "waits", round), tally);
    if (chaos.pairs != calm.pairs) tally.Lost("pairs of the study with waits differ under chaos");
    if (chaos.results != calm.results) tally.Lost("results of jobs that waited differ under chaos");
    tally.figures["waiting_jobs"] += static_cast<double>(chaos.results.size());
  }
}

}  // namespace parallax::faults
