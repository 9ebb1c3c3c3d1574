#include "tests/faults/life.h"

#include <sys/mman.h>

#include <cstring>
#include <shared_mutex>
#include <thread>

#include "tests/coordinator/queue/train_fixture.h"
#include "tests/noop/noop_kind.h"

namespace parallax::faults {

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

namespace {

constexpr int kStudies = 3;  // The last one may be cancelled.
constexpr int kWorkers = 3;  // Workers of each client.

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
    Stream();
    Search();
    Notice();
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

  void Stream() {
    v1::StreamRecord record;
    record.mutable_study()->set_name("stream");
    record.set_chunks_forgotten(number_);
    (void)queue_.KeepStream(record);
    if (number_ % 2 == 0) (void)queue_.RemoveStream("stream");
  }

  void Search() {
    v1::SearchRecord record;
    record.mutable_study()->set_name("search");
    record.set_opened_unix_s(number_);
    (void)queue_.KeepSearch(record);
    if (number_ % 2 == 0) (void)queue_.RemoveSearch("search");
  }

  // What a person says of a study, and what the operator hears of it.
  void Notice() {
    (void)queue_.Comment(StudyId{studies_[1]}, "slow", "client");
    (void)queue_.SetPriority(StudyId{studies_[1]}, 5, "", "client");
    (void)queue_.SetPriority(StudyId{studies_[1]}, 6, "", "client");
    (void)queue_.RaiseNotice(StudyId{studies_[1]}, kNoticeStalled);
    const auto notices = queue_.ListNotices(2);
    if (!notices.ok() || notices->empty()) return;
    (void)queue_.DelayNotice(notices->back(), 1);
    (void)queue_.EndNotice(notices->front());
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

}  // namespace parallax::faults
