#include "tests/faults/life.h"

#include <sys/mman.h>

#include <cstring>
#include <shared_mutex>
#include <thread>

#include "tests/coordinator/queue/train_fixture.h"
#include "tests/noop/noop_kind.h"

namespace parallax::faults {
namespace {

constexpr int kStudies = 3;  // The last one may be cancelled.
constexpr int kWorkers = 3;  // Workers of each client.

// Each study's noop jobs wait for its pairs and for each other.
const KindRegistry& Kinds() {
  static const NoopKind* noop = new NoopKind(NoopKind::AfterPairs);
  static const KindRegistry* kinds = new KindRegistry(KindRegistry::Builtin().With(*noop));
  return *kinds;
}

WorkerFacts LivingWorker(const std::string& name) {
  WorkerFacts worker = Everyman(name);
  worker.kinds.push_back("noop");
  return worker;
}

v1::CompleteRequest AnswerOf(const v1::Lease& lease, const std::string& worker) {
  if (lease.kind() != "noop") return AnyAnswer(lease, worker);
  v1::CompleteRequest request;
  *request.mutable_attempt() = lease.attempt();
  request.set_worker(worker);
  request.set_kind("noop");
  request.set_result("done");
  return request;
}

StudyOptions StudyOf(int index) {
  return {.name = "study" + std::to_string(index),
          .seed = static_cast<uint64_t>(1 + index),
          .pairs = 6 + 4 * index,
          .rigs_per_scene = 2,
          .variants =
              index == 1 ? std::vector<std::string>{"a", "b"} : std::vector<std::string>{"only"},
          .priority = index == 2 ? 1 : 0,
          .key = "key" + std::to_string(index)};
}

// One client's calls. Each is announced if it may end leases, and acknowledged when it returned.
class Client {
 public:
  Client(JobQueue& queue, FakeClock& clock, int number, Rng rng, AckLog& acks,
         std::shared_mutex& order)
      : queue_(queue), clock_(clock), number_(number), rng_(rng), acks_(acks), order_(order) {}

  void Run(int steps) {
    for (int i = 0; i < kStudies; ++i) Submit(i);
    for (int i = 0; i < steps; ++i) Step();
  }
  // The commands that are drawn so seldom that a life may end without them. Alone.
  void RareCommands() {
    Retry(0);
    Cancel();
    Forget();
    Drain();
    Limit();
    Repair();
  }

 private:
  struct Held {
    v1::Lease lease;
    std::string worker;
  };

  std::string WorkerName(int i) const {
    return "w" + std::to_string(number_) + "-" + std::to_string(i);
  }
  std::string AnyName() { return WorkerName(rng_.UniformInt(0, kWorkers - 1)); }

  void Acknowledge(Ack::Kind kind, int64_t study, const v1::AttemptId& attempt = {},
                   const std::string& worker = "") {
    Ack ack{kind, number_, study, attempt.job_id(), attempt.fence(), {}};
    std::strncpy(ack.worker, worker.c_str(), sizeof ack.worker - 1);
    acks_.Add(ack);
  }

  void Submit(int index) {
    const v1::SubmitRequest study = MakeStudy(StudyOf(index));
    const auto reply = queue_.Submit(index == 0 ? WithTrainings(study, 2) : study, "client");
    if (!reply.ok()) return;
    studies_[index] = reply->study_id();
    Acknowledge(Ack::kStudy, reply->study_id());
  }

  void Step() {
    const int draw = rng_.UniformInt(0, 99);
    // A call that may end others' leases is alone, so that the acks stand in the calls' order.
    std::shared_lock many(order_, std::defer_lock);
    std::unique_lock alone(order_, std::defer_lock);
    draw < 62 ? many.lock() : alone.lock();
    if (draw < 32) {
      Lease();
    } else if (draw < 62) {
      Complete();
    } else if (draw < 69) {
      Fail();
    } else if (draw < 74) {
      HandBack();
    } else if (draw < 78) {
      Adopt();
    } else if (draw < 81) {
      WorkerLost();
    } else if (draw < 87) {
      Tick();
    } else if (draw < 92) {
      PauseOrResume();
    } else if (draw < 94) {
      Retry(rng_.UniformInt(0, kStudies - 1));
    } else if (draw < 95) {
      Cancel();
    } else {
      ReportLate();
    }
  }

  void Lease() {
    const std::string worker = AnyName();
    const auto leases = queue_.Lease(LivingWorker(worker), rng_.UniformInt(1, 3));
    if (!leases.ok()) return;
    for (const v1::Lease& lease : *leases) {
      Acknowledge(Ack::kLeased, 0, lease.attempt(), worker);
      held_.push_back({lease, worker});
    }
  }

  // A lease of ours, which is ours no longer.
  std::optional<Held> Take() {
    if (held_.empty()) return std::nullopt;
    const auto at = held_.begin() + rng_.UniformInt(0, static_cast<int>(held_.size()) - 1);
    Held held = *at;
    held_.erase(at);
    over_.push_back(held);
    return held;
  }

  void Complete() {
    const auto held = Take();
    if (!held) return;
    // A rejection may make its variant give up, which cancels others.
    const bool reject = held->lease.kind() == "solve" && rng_.Bernoulli(0.15);
    Acknowledge(Ack::kMayEnd, 0, reject ? v1::AttemptId() : held->lease.attempt());
    const auto outcome =
        queue_.Complete(reject ? RejectAnswer(held->lease, held->worker, rng_.Bernoulli(0.5))
                               : AnswerOf(held->lease, held->worker));
    if (reject) Acknowledge(Ack::kGone, 0);
    if (outcome.ok() && *outcome == v1::REPORT_OUTCOME_OK) {
      Acknowledge(Ack::kCompleted, 0, held->lease.attempt(), held->worker);
    }
  }

  void Fail() {
    const auto held = Take();
    if (!held) return;
    Acknowledge(Ack::kMayEnd, 0);
    const auto outcome = queue_.Fail(Failure(
        held->lease, held->worker, rng_.Bernoulli(0.5) ? "bang" : "boom", rng_.Bernoulli(0.8)));
    Acknowledge(Ack::kGone, 0);
    if (outcome.ok() && *outcome == v1::REPORT_OUTCOME_OK) {
      Acknowledge(Ack::kFailed, 0, held->lease.attempt(), held->worker);
    }
  }

  void HandBack() {
    const auto held = Take();
    if (!held) return;
    Acknowledge(Ack::kMayEnd, 0, held->lease.attempt());
    const auto outcome = queue_.HandBack(held->worker, held->lease.attempt(), "drain");
    if (outcome.ok() && *outcome == v1::REPORT_OUTCOME_OK) {
      Acknowledge(Ack::kHandedBack, 0, held->lease.attempt(), held->worker);
    }
  }

  // A worker comes back and has forgotten some of what it held.
  void Adopt() {
    const std::string worker = AnyName();
    std::vector<v1::AttemptId> holding;
    std::vector<Held> kept;
    for (const Held& held : held_) {
      if (held.worker == worker && rng_.Bernoulli(0.3)) {
        over_.push_back(held);
        continue;
      }
      if (held.worker == worker) holding.push_back(held.lease.attempt());
      kept.push_back(held);
    }
    Acknowledge(Ack::kMayEnd, 0);
    (void)queue_.Adopt(worker, holding);
    Acknowledge(Ack::kGone, 0);
    held_ = std::move(kept);
  }

  void WorkerLost() {
    const std::string worker = AnyName();
    Acknowledge(Ack::kMayEnd, 0);
    (void)queue_.WorkerLost(worker);
    Acknowledge(Ack::kGone, 0);
    std::erase_if(held_, [&](const Held& held) {
      if (held.worker == worker) over_.push_back(held);
      return held.worker == worker;
    });
  }

  void Tick() {
    Acknowledge(Ack::kMayEnd, 0);
    clock_.Advance(rng_.Uniform(1, 40));
    (void)queue_.Tick();
    Acknowledge(Ack::kGone, 0);
    // The janitor's part.
    const auto litter = queue_.ListLitter(/*older_than_s=*/0, /*limit=*/3);
    if (litter.ok() && !litter->empty()) (void)queue_.ForgetLitter(*litter);
  }

  void PauseOrResume() {
    // Pause and Resume take turns, so that each has an effect.
    const StudyId study{studies_[0]};
    if (!paused_) {
      (void)queue_.Pause(study, "", "client");
    } else {
      (void)queue_.Resume(study, "", "client");
    }
    paused_ = !paused_;
  }

  void Retry(int study) {
    Acknowledge(Ack::kMayEnd, 0);
    (void)queue_.Retry(StudyId{studies_[study]}, "client");
    Acknowledge(Ack::kGone, 0);
  }

  void Cancel() {
    const int64_t study = studies_[kStudies - 1];
    Acknowledge(Ack::kMayEnd, 0);
    if (queue_.Cancel(StudyId{study}, "enough", "client").ok()) {
      Acknowledge(Ack::kCancelled, study);
    }
    Acknowledge(Ack::kGone, 0);
  }

  // A study of its own, equal to the first as far as that has come.
  void Forget() {
    StudyOptions options = StudyOf(0);
    options.name = "gone";
    options.key = "gone" + std::to_string(number_);
    const auto reply = queue_.Submit(MakeStudy(options), "client");
    if (!reply.ok()) return;
    Lease();
    Acknowledge(Ack::kMayEnd, 0);
    (void)queue_.Cancel(StudyId{reply->study_id()}, "enough", "client");
    Acknowledge(Ack::kGone, 0);
    (void)queue_.Forget(StudyId{reply->study_id()}, "not needed", "client");
    for (int i = 0; i < 4; ++i) Tick();
  }

  // Small enough to hold leases back for a while.
  void Limit() {
    (void)queue_.SetMaxRunning(StudyId{studies_[1]}, 1, "room", "client");
    for (int i = 0; i < 3; ++i) Lease();
    queue_.KeepSample({.unix_s = clock_.UnixSeconds(), .ready = number_});
    (void)queue_.SetMaxRunning(StudyId{studies_[1]}, 0, "", "client");
  }

  void Drain() {
    v1::DrainOrder order;
    order.set_pattern("w?-*");
    order.set_actor("client");
    (void)queue_.Drain(order, /*undo=*/false);
    (void)queue_.Drain(order, /*undo=*/true);
  }

  // A bit of a published result has flipped.
  void Repair() {
    const auto outputs = queue_.ListStoredOutputs("", 2);
    if (!outputs.ok() || outputs->empty()) return;
    const StoredOutput& output = outputs->front();
    (void)queue_.TakeBack({{output.key, output.folder, "a bit has flipped"}}, "client");
    (void)queue_.KeepScrub(
        {.position = std::string(output.key.begin(), output.key.end()), .files = number_});
  }

  // Acts as a zombie: reports a result under a lease that ended long ago.
  void ReportLate() {
    if (over_.empty()) return;
    const Held& held =
        over_[static_cast<size_t>(rng_.UniformInt(0, static_cast<int>(over_.size()) - 1))];
    const auto lease = held.lease.attempt();
    // Our lease may have been lost by a call that failed; then the report is not late.
    for (const Held& other : held_) {
      if (other.lease.attempt().fence() == lease.fence()) return;
    }
    if (ended_.count(lease.fence()) == 0) {
      // Make sure that it is over.
      Acknowledge(Ack::kMayEnd, 0);
      (void)queue_.WorkerLost(held.worker);
      Acknowledge(Ack::kGone, 0);
      std::erase_if(held_, [&](const Held& other) { return other.worker == held.worker; });
      ended_.insert(lease.fence());
    }
    const auto outcome = queue_.Complete(AnswerOf(held.lease, held.worker));
    if (outcome.ok() && *outcome == v1::REPORT_OUTCOME_OK) {
      Acknowledge(Ack::kViolation, 0, lease, held.worker);
    }
  }

  JobQueue& queue_;
  FakeClock& clock_;
  const int number_;
  Rng rng_;
  AckLog& acks_;
  std::shared_mutex& order_;
  int64_t studies_[kStudies] = {};
  bool paused_ = false;  // The first study.
  std::vector<Held> held_;
  std::vector<Held> over_;
  std::set<uint64_t> ended_;
};

}  // namespace

AckLog::AckLog() {
  shared_ = static_cast<Shared*>(
      mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  if (shared_ == MAP_FAILED) std::abort();
}

AckLog::~AckLog() { munmap(shared_, sizeof(Shared)); }

void AckLog::Add(const Ack& ack) {
  const size_t at = shared_->next.fetch_add(1);
  if (at >= kCapacity) std::abort();
  shared_->acks[at] = ack;
  shared_->whole[at].store(true);
}

size_t AckLog::size() const { return std::min(shared_->next.load(), kCapacity); }

void Live(const LifeOptions& options, Rng rng, AckLog& acks) {
  JobQueueOptions queue = options.queue;
  queue.kinds = &Kinds();
  auto opened = JobQueue::Open(queue);
  if (!opened.ok()) {
    std::fprintf(stderr, "open: %s\n", opened.status().ToString().c_str());
    _exit(3);
  }
  std::shared_mutex order;
  std::vector<std::thread> threads;
  for (int i = 0; i < options.clients; ++i) {
    const auto run = [&, i] {
      Client client(**opened, *options.clock, i, rng.Child("client", static_cast<uint64_t>(i)),
                    acks, order);
      client.Run(options.steps);
      if (options.rare_commands) client.RareCommands();
    };
    if (options.clients == 1) {
      run();
    } else {
      threads.emplace_back(run);
    }
  }
  for (std::thread& thread : threads) thread.join();
}

// ---- The witness --------------------------------------------------------------------------------
void Witness::NoteFence(uint64_t fence) {
  if (!fences_.insert(fence).second) {
    tally_.Doubled("fence " + std::to_string(fence) + " was issued twice");
  }
}

std::unique_ptr<JobQueue> Witness::Open() {
  JobQueueOptions options = options_.queue;
  options.fail_point = nullptr;
  options.kinds = &Kinds();
  auto queue = JobQueue::Open(options);
  if (!queue.ok()) {
    tally_.Lost("the database does not open: " + queue.status().ToString());
    return nullptr;
  }
  return *std::move(queue);
}

void Witness::Audit(JobQueue& queue, const std::string& where) {
  const auto violations = queue.Check();
  if (!violations.ok()) return tally_.Lost("the auditor fails: " + violations.status().ToString());
  tally_.Found(*violations, where);
}

void Witness::Verify(const AckLog& acks) {
  std::set<int32_t>
      ending;  // Clients whose call may have ended any lease, also one granted meanwhile.
  for (size_t i = 0; i < acks.size(); ++i) {
    if (!acks.IsWhole(i)) continue;
    const Ack& ack = acks[i];
    const std::pair<int64_t, uint64_t> attempt(ack.job, ack.fence);
    switch (ack.kind) {
      case Ack::kStudy:
        studies_.insert(ack.study);
        break;
      case Ack::kCancelled:
        cancelled_.insert(ack.study);
        break;
      case Ack::kLeased:
        NoteFence(ack.fence);
        held_[attempt] = ack.worker;
        break;
      case Ack::kCompleted:
      case Ack::kFailed:
      case Ack::kHandedBack:
        held_.erase(attempt);
        reports_[attempt] = ack;
        break;
      case Ack::kMayEnd:
      case Ack::kGone:
        if (ack.job != 0) {
          held_.erase(attempt);
          break;
        }
        held_.clear();
        if (ack.kind == Ack::kMayEnd) {
          ending.insert(ack.client);
        } else {
          ending.erase(ack.client);
        }
        break;
      case Ack::kViolation:
        tally_.Doubled("a late result of job " + std::to_string(ack.job) + " was accepted");
        break;
    }
  }
  if (!ending.empty()) held_.clear();
  const auto queue = Open();
  if (queue == nullptr) return;
  Audit(*queue, "after the fault");
  VerifyStudies(*queue);
  VerifyReports(*queue);
  VerifyLeases(*queue);
}

void Witness::VerifyStudies(JobQueue& queue) {
  for (const int64_t study : studies_) {
    const auto status = queue.GetStudy(StudyId{study});
    if (!status.ok()) {
      tally_.Lost("study " + std::to_string(study) + ": " + status.status().ToString());
    } else if (cancelled_.count(study) != 0 && status->state() != v1::STUDY_STATE_CANCELLED) {
      tally_.Lost("the cancel of study " + std::to_string(study));
    } else if (status->state() == v1::STUDY_STATE_CANCELLED) {
      cancelled_.insert(study);  // Committed, not answered.
    }
  }
}

// Each report again: it is known, whatever has happened since.
void Witness::VerifyReports(JobQueue& queue) {
  for (const auto& [key, ack] : reports_) {
    v1::AttemptId attempt;
    attempt.set_job_id(ack.job);
    attempt.set_fence(ack.fence);
    absl::StatusOr<v1::ReportOutcome> outcome = v1::REPORT_OUTCOME_UNSPECIFIED;
    if (ack.kind == Ack::kCompleted) {
      v1::CompleteRequest request;
      *request.mutable_attempt() = attempt;
      request.set_worker(ack.worker);
      outcome = queue.Complete(request);
    } else if (ack.kind == Ack::kFailed) {
      v1::FailRequest request;
      *request.mutable_attempt() = attempt;
      request.set_worker(ack.worker);
      outcome = queue.Fail(request);
    } else {
      outcome = queue.HandBack(ack.worker, attempt, "again");
    }
    if (!outcome.ok() || *outcome != v1::REPORT_OUTCOME_ALREADY_DONE) {
      tally_.Lost("report of job " + std::to_string(ack.job) + ", attempt " +
                  std::to_string(ack.fence) + ": " +
                  (outcome.ok() ? v1::ReportOutcome_Name(*outcome) : outcome.status().ToString()));
    }
  }
}

void Witness::VerifyLeases(JobQueue& queue) {
  std::map<std::string, std::vector<v1::AttemptId>> of_worker;
  for (const auto& [key, worker] : held_) {
    v1::AttemptId& attempt = of_worker[worker].emplace_back();
    attempt.set_job_id(key.first);
    attempt.set_fence(key.second);
  }
  for (const auto& [worker, holding] : of_worker) {
    const auto adopted = queue.Adopt(worker, holding);
    if (!adopted.ok() || adopted->size() != holding.size()) {
      tally_.Lost("of " + std::to_string(holding.size()) + " leases of " + worker + ", " +
                  (adopted.ok() ? std::to_string(adopted->size()) + " are adopted"
                                : adopted.status().ToString()));
      for (const v1::AttemptId& attempt : holding) {
        v1::CompleteRequest request;
        *request.mutable_attempt() = attempt;
        const auto outcome = queue.Complete(request);
        tally_.complaints.push_back(
            "  job " + std::to_string(attempt.job_id()) + ", attempt " +
            std::to_string(attempt.fence()) + ": " +
            (outcome.ok() ? v1::ReportOutcome_Name(*outcome) : outcome.status().ToString()));
        std::fprintf(stderr, "%s\n", tally_.complaints.back().c_str());
      }
      continue;
    }
    for (const v1::AttemptId& attempt : *adopted) {
      (void)queue.HandBack(worker, attempt, "end of a life");
    }
  }
  held_.clear();
}

void Witness::Finish() {
  const auto queue = Open();
  if (queue == nullptr) return;
  for (const int64_t study : studies_) (void)queue->Resume(StudyId{study}, "", "witness");
  const WorkerFacts worker = LivingWorker("finisher");
  for (int idle = 0; idle < 12;) {
    const auto leases = queue->Lease(worker, 8);
    if (!leases.ok()) return tally_.Lost("lease: " + leases.status().ToString());
    if (leases->empty()) {
      ++idle;
      options_.clock->Advance(300);  // Longer than a lease and, twelve times, than any back-off.
      (void)queue->Tick();
      continue;
    }
    idle = 0;
    for (const v1::Lease& lease : *leases) {
      NoteFence(lease.attempt().fence());
      const auto outcome = queue->Complete(AnswerOf(lease, worker.name));
      if (!outcome.ok() || *outcome != v1::REPORT_OUTCOME_OK) {
        tally_.Lost("job " + std::to_string(lease.attempt().job_id()) + " can't be completed");
      }
    }
  }
  for (const int64_t study : studies_) CountPairs(*queue, study);
  Audit(*queue, "at the end");
}

void Witness::CountPairs(JobQueue& queue, int64_t study) {
  const auto status = queue.GetStudy(StudyId{study});
  if (!status.ok()) return tally_.Lost("study " + std::to_string(study));
  v1::ListFramesRequest request;
  request.set_study_id(study);
  request.set_limit(10'000);
  const auto frames = queue.ListFrames(request);
  if (!frames.ok()) return tally_.Lost("frames: " + frames.status().ToString());
  std::set<std::tuple<std::string, uint32_t, uint32_t>> seen;
  for (const v1::PublishedFrame& frame : *frames) {
    if (!seen.insert({frame.variant(), frame.scene(), frame.frame().rig()}).second) {
      tally_.Doubled("a frame of study " + std::to_string(study));
    }
  }
  int64_t wanted = 0;
  for (const v1::VariantStatus& variant : status->variants()) {
    wanted += variant.pairs_wanted();
    tally_.jobs += JobsOf(variant, "", "SUCCEEDED");
  }
  // A job that waits for pairs has ended, in some way, when they are there.
  for (const v1::VariantStatus& variant : status->variants()) {
    for (const char* kind : {"noop", "train", "evaluate"}) {
      if (JobsOf(variant, kind, "BLOCKED") + JobsOf(variant, kind, "READY") > 0) {
        tally_.Lost(std::string(kind) + " jobs of study " + std::to_string(study) + " are stuck");
      }
    }
  }
  // A variant that gave up after too many rejections has said so; its study is not short of a pair
  // by a fault.
  bool gave_up = false;
  int64_t others_lost = 0;
  for (const v1::VariantStatus& variant : status->variants()) {
    for (const v1::JobProblem& problem : variant.problems()) {
      gave_up |= problem.state() == "GAVE_UP";
    }
    for (const char* kind : {"noop", "train", "evaluate"}) {
      for (const char* state : {"FAILED", "QUARANTINED", "CANCELLED"}) {
        others_lost += JobsOf(variant, kind, state);
      }
    }
  }
  if (status->state() == v1::STUDY_STATE_CANCELLED || gave_up) return;
  const bool succeeded = status->state() == v1::STUDY_STATE_SUCCEEDED ||
                         (status->state() == v1::STUDY_STATE_FAILED && others_lost > 0);
  if (!succeeded || static_cast<int64_t>(seen.size()) != wanted) {
    tally_.Lost("study " + std::to_string(study) + " is " + v1::StudyState_Name(status->state()) +
                " with " + std::to_string(seen.size()) + " of " + std::to_string(wanted) +
                " pairs");
  }
}

}  // namespace parallax::faults
