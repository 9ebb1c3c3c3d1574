#include "coordinator/rpc/workers/dispatcher.h"

#include <pthread.h>

#include <algorithm>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

#include "common/base/seconds.h"
#include "common/base/system/log.h"
#include "coordinator/queue/tables/latency_histogram.h"
#include "coordinator/rpc/reply_size.h"
#include "coordinator/rpc/validation.h"
#include "coordinator/rpc/workers/ask_window.h"
#include "coordinator/rpc/workers/fleet.h"
#include "coordinator/rpc/workers/lease_inbox.h"
#include "coordinator/rpc/workers/lease_returns.h"

namespace parallax {
namespace {

constexpr int kMostAskedAtOnce = 64;  // Jobs of one worker in one call.
// A wake-up that went missing costs at most this.
constexpr double kLookAgain_s = 1;

WorkerClass ClassOf(const WorkerFacts& facts) { return {facts.kinds, facts.memory_mb, facts.tags}; }

struct Outgoing {
  std::shared_ptr<WorkerLink> link;
  v1::CoordinatorMessage message;
};

}  // namespace

class Dispatcher::Impl {
 public:
  Impl(JobQueue& queue, TaskPool& pool, Clock& clock, double reconnect_grace_s, bool own_thread)
      : queue_(queue),
        pool_(pool),
        clock_(clock),
        check_every_s_(std::min(0.25, GraceOf(queue, reconnect_grace_s) / 4)),
        fleet_(queue, queue.lease_s(), GraceOf(queue, reconnect_grace_s)),
        look_at_(SecondsAfter(clock.Steady(), kLookAgain_s)),
        check_at_(clock.Steady()) {
    if (own_thread) thread_ = std::thread([this] { Loop(); });
  }

  absl::Status Join(const std::shared_ptr<WorkerLink>& link, const v1::Hello& hello,
                    const std::function<void(const std::vector<v1::AttemptId>&)>& welcome) {
    bool same_process = false;
    {
      std::lock_guard lock(mu_);
      if (joining_.count(hello.name()) > 0) {
        return Aborted("worker {} is already being taken in", hello.name());
      }
      if (forfeiting_->Has(hello.name())) {
        return Aborted("worker {}: the leases that it had before are being given up", hello.name());
      }
      const auto& workers = fleet_.workers();
      if (workers.count(hello.name()) == 0 && workers.size() + joining_.size() >= kMostWorkers) {
        return ResourceExhausted("no room for worker {}: a coordinator has at most {}",
                                 hello.name(), kMostWorkers);
      }
      joining_.insert(hello.name());
      same_process = fleet_.IsSameProcess(hello);
      fleet_.DropLink(hello, clock_.Steady());
    }
    auto adopted =
        queue_.Adopt(hello.name(), {hello.holding().begin(), hello.holding().end()}, same_process);
    std::lock_guard lock(mu_);
    joining_.erase(hello.name());
    if (!adopted.ok()) return adopted.status();
    if (stopping_) return Unavailable("the coordinator is stopping");
    welcome(*adopted);
    fleet_.TakeIn(link, hello, clock_.Steady());
    LogInfo("worker connected", {{"worker", hello.name()},
                                 {"slots", hello.slots()},
                                 {"version", hello.version()},
                                 {"holding", hello.holding_size()},
                                 {"adopted", adopted->size()}});
    return absl::OkStatus();
  }

  void AddCredit(const std::string& name, const WorkerLink* link, const v1::Credit& credit) {
    std::lock_guard lock(mu_);
    FleetWorker* worker = fleet_.Present(name, link);
    if (worker == nullptr) return;
    worker->AddCredit(credit, clock_.Steady());
    inbox_->Poke();
  }

  void Heard(const std::string& name, WorkerLink* link, const v1::Heartbeat& heartbeat) {
    {
      std::lock_guard lock(mu_);
      if (FleetWorker* worker = fleet_.Present(name, link); worker != nullptr) {
        worker->heard = clock_.Steady();
        worker->draining = heartbeat.draining();
      }
    }
    for (const v1::AttemptId& attempt :
         queue_.Heartbeat(name, {heartbeat.running().begin(), heartbeat.running().end()})) {
      v1::CoordinatorMessage message;
      *message.mutable_stop()->mutable_attempt() = attempt;
      message.mutable_stop()->set_reason("its lease is over");
      link->Send(std::move(message));
    }
    v1::CoordinatorMessage ack;
    ack.mutable_heartbeat_ack()->set_sequence(heartbeat.sequence());
    link->Send(std::move(ack));
  }

  void Left(const std::string& name, const WorkerLink* link) {
    std::lock_guard lock(mu_);
    FleetWorker* worker = fleet_.Present(name, link);
    if (worker == nullptr) return;
    if (fleet_.Break(*worker, clock_.Steady())) {
      ForfeitLeases(queue_, pool_, forfeiting_, name, /*drained=*/true);
    }
  }

  void Reported(const std::string& name, bool succeeded) {
    std::lock_guard lock(mu_);
    fleet_.Reported(name, succeeded, clock_.Steady());
  }

  void HoldLeases(bool hold) {
    std::lock_guard lock(mu_);
    hold_ = hold;
    if (!hold) inbox_->WorkIsReady();
  }

  std::vector<v1::WorkerStatus> Workers() {
    std::lock_guard lock(mu_);
    TakeNewDrains();
    return fleet_.Statuses(clock_.Steady());
  }

  std::vector<WorkerGroup> WorkerGroups() {
    std::lock_guard lock(mu_);
    TakeNewDrains();
    return fleet_.Groups(clock_.Steady());
  }

  ServerMetrics Metrics() const {
    std::lock_guard lock(mu_);
    ServerMetrics metrics;
    fleet_.Count(metrics);
    metrics.leases = leases_;
    metrics.lease_latency_bounds_s = latency_s_.bounds();
    metrics.lease_latency_counts = latency_s_.Cumulative();
    metrics.lease_latency_sum_s = latency_sum_s_;
    return metrics;
  }

  void Stop() {
    {
      std::lock_guard lock(mu_);
      if (stopping_) return;
      stopping_ = true;
      inbox_->Poke();
    }
    if (thread_.joinable()) thread_.join();
    std::lock_guard lock(mu_);
    fleet_.CloseAll(Unavailable("the coordinator is stopping"));
  }

  SteadyTime Work() {
    Round(SteadyTime());  // Waits for nothing, whatever time it is here and there.
    return NextLook();
  }

  void OnWorkReady() { inbox_->WorkIsReady(); }

  void OnDrains(const std::vector<v1::DrainOrder>& drains) {
    {
      std::lock_guard lock(drains_mu_);
      new_drains_ = drains;
    }
    inbox_->Poke();
  }

  std::vector<std::string> ConnectedLike(const std::string& pattern) const {
    std::lock_guard lock(mu_);
    return fleet_.ConnectedLike(pattern);
  }

  void OnStop(const std::string& worker, const v1::AttemptId& attempt, const std::string& reason) {
    LeaseNote note;
    note.kind = LeaseNote::kStop;
    note.worker = worker;
    note.attempt = attempt;
    note.reason = reason;
    inbox_->Leave(std::move(note));
  }

 private:
  static double GraceOf(const JobQueue& queue, double reconnect_grace_s) {
    return std::min(reconnect_grace_s, queue.lease_s());
  }

  // ---- All below require mu_ unless said otherwise
  void TakeNewDrains() {
    if (!knows_drains_) ReadDrains();
    std::lock_guard lock(drains_mu_);
    if (!new_drains_) return;
    fleet_.SetDrains(*std::move(new_drains_));
    new_drains_.reset();
    knows_drains_ = true;
  }

  // Until it succeeds, nobody gets work: a drained worker might.
  void ReadDrains() {
    auto drains = queue_.Drains();
    if (!drains.ok()) {
      return LogError("no work is given: orders to drain are not known",
                      {{"error", drains.status()}});
    }
    std::lock_guard lock(drains_mu_);
    if (!new_drains_) new_drains_ = *std::move(drains);  // The queue's own news are newer.
  }

  // ---- The dispatcher's thread
  void Loop() {
    pthread_setname_np(pthread_self(), "dispatcher");
    while (!Round(NextLook())) continue;
  }

  SteadyTime NextLook() const { return std::min(look_at_, check_at_); }

  // Does all that is due when there is news, at the latest at `until`. Returns true if it was the
  // last round.
  bool Round(SteadyTime until) {
    std::deque<LeaseNote> notes;
    const bool work_ready = inbox_->Take(until, &notes);
    std::vector<Outgoing> outbox;
    const bool over = Turn(notes, work_ready, &outbox);
    // Writes to hundreds of sockets; callers with credit or heartbeats don't wait for it.
    for (Outgoing& outgoing : outbox) outgoing.link->Send(std::move(outgoing.message));
    return over;
  }

  // Does all that is due now. Returns true if it was the last turn.
  bool Turn(std::deque<LeaseNote>& notes, bool work_ready, std::vector<Outgoing>* outbox) {
    std::lock_guard lock(mu_);
    TakeNewDrains();
    for (LeaseNote& note : notes) Handle(note, outbox);
    const SteadyTime now = clock_.Steady();
    if (now >= look_at_) {
      look_at_ = SecondsAfter(now, kLookAgain_s);
      work_ready = true;
    }
    if (work_ready) NewRound(now);
    if (now >= check_at_) {
      check_at_ = SecondsAfter(now, check_every_s_);
      for (const std::string& lost : fleet_.CheckPresence(now)) {
        ForfeitLeases(queue_, pool_, forfeiting_, lost, /*drained=*/false);
      }
    }
    if (stopping_) return inbox_->IsQuiet();
    Ask();
    return false;
  }

  void NewRound(SteadyTime now) {
    ++round_;
    for (auto& [key, window] : windows_) window.NewRound();
    // For the latency: a worker that waited can't have been served before there was work.
    for (auto& [name, worker] : fleet_.workers()) {
      if (!worker.asking && worker.credit > 0 && worker.served_round != 0) worker.wants_since = now;
    }
  }

  void Handle(LeaseNote& note, std::vector<Outgoing>* outbox) {
    if (note.kind == LeaseNote::kStop) {
      SendStop(note, outbox);
    } else {
      HandleLeases(note, outbox);
    }
  }

  void SendStop(const LeaseNote& note, std::vector<Outgoing>* outbox) {
    const auto found = fleet_.workers().find(note.worker);
    if (found == fleet_.workers().end() || found->second.link == nullptr) return;
    v1::CoordinatorMessage message;
    *message.mutable_stop()->mutable_attempt() = note.attempt;
    message.mutable_stop()->set_reason(note.reason);
    outbox->push_back({found->second.link, std::move(message)});
  }

  void HandleLeases(LeaseNote& note, std::vector<Outgoing>* outbox) {
    if (!note.leases.ok()) {
      LogError("no leases from the queue", {{"error", note.leases.status()}});
      note.leases = std::vector<v1::Lease>();
    }
    const int got = static_cast<int>(note.leases->size());
    windows_[note.of_class].Answered(got, note.round == round_);
    const std::shared_ptr<WorkerLink> link = note.link.lock();
    FleetWorker* worker = link == nullptr ? nullptr : fleet_.Present(note.worker, link.get());
    if (worker == nullptr || stopping_) {
      if (worker != nullptr) worker->asking = false;
      return HandBackLeases(queue_, pool_, note.worker, *note.leases);
    }
    worker->asking = false;
    if (got < note.asked) worker->served_round = note.round;
    const double latency_s = SecondsBetween(worker->wants_since, clock_.Steady());
    for (v1::Lease& lease : *note.leases) {
      v1::CoordinatorMessage message;
      *message.mutable_lease() = std::move(lease);
      outbox->push_back({link, std::move(message)});
      --worker->credit;
      worker->ahead = std::min(worker->ahead, worker->credit);
      ++leases_;
      latency_s_.Add(latency_s);
      latency_sum_s_ += latency_s;
    }
    worker->wants_since = clock_.Steady();
  }

  // Workers ask in turn, so that the last in the alphabet is not always served last.
  void Ask() {
    std::map<std::string, FleetWorker>& workers = fleet_.workers();
    if (workers.empty() || hold_ || !knows_drains_) return;
    const SteadyTime now = clock_.Steady();
    std::optional<FarmByKind> farm;
    auto it = workers.upper_bound(last_asked_);
    for (size_t i = 0; i < workers.size(); ++i, ++it) {
      if (it == workers.end()) it = workers.begin();
      FleetWorker& worker = it->second;
      if (!fleet_.TakesWork(worker) || worker.asking || worker.credit <= 0 ||
          worker.served_round == round_ || fleet_.TrustIn(worker, now) <= 0) {
        continue;
      }
      const WorkerClass key = ClassOf(worker.facts);
      AskWindow& window = windows_[key];
      if (!window.IsOpen()) continue;
      window.Asked();
      if (!farm) farm = fleet_.SlotsByKind(now);
      AskFor(worker, key, *farm);
      for (const std::string& kind : worker.facts.kinds) {
        const auto slots = farm->find(kind);
        if (slots != farm->end()) slots->second.idle -= worker.IdleSlots(now);
      }
      last_asked_ = it->first;
    }
  }

  void AskFor(FleetWorker& worker, const WorkerClass& key, const FarmByKind& farm) {
    worker.asking = true;
    worker.facts.farm = farm;
    const int jobs = std::min(fleet_.TrustIn(worker, clock_.Steady()), kMostAskedAtOnce);
    LeaseNote note;
    note.worker = worker.facts.name;
    note.link = worker.link;
    note.of_class = key;
    note.round = round_;
    note.asked = jobs;
    inbox_->CallBegins();
    queue_.LeaseAsync(worker.facts, jobs,
                      [inbox = inbox_, note = std::move(note)](
                          absl::StatusOr<std::vector<v1::Lease>> leases) mutable {
                        note.leases = std::move(leases);
                        inbox->CallEnds(std::move(note));
                      });
  }

  JobQueue& queue_;
  TaskPool& pool_;
  Clock& clock_;
  const double check_every_s_;
  const std::shared_ptr<LeaseInbox> inbox_ = std::make_shared<LeaseInbox>();
  const std::shared_ptr<ForfeitingWorkers> forfeiting_ = std::make_shared<ForfeitingWorkers>();

  // The queue's thread leaves orders here and never waits for mu_. Taken after mu_.
  std::mutex drains_mu_;
  std::optional<std::vector<v1::DrainOrder>> new_drains_;  // Guarded by drains_mu_.

  mutable std::mutex mu_;  // Taken before the inbox's.
  // Guarded by mu_.
  Fleet fleet_;
  std::map<WorkerClass, AskWindow> windows_;
  std::set<std::string> joining_;
  std::string last_asked_;
  uint64_t round_ = 1;  // 0: in no round.
  bool stopping_ = false;
  bool hold_ = false;
  bool knows_drains_ = false;
  int64_t leases_ = 0;
  CountHistogram latency_s_{{0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5}};
  double latency_sum_s_ = 0;

  // Used by the dispatcher's thread alone.
  SteadyTime look_at_;
  SteadyTime check_at_;

  std::thread thread_;
};

Dispatcher::Dispatcher(JobQueue& queue, TaskPool& pool, Clock& clock, double reconnect_grace_s,
                       bool own_thread)
    : impl_(std::make_unique<Impl>(queue, pool, clock, reconnect_grace_s, own_thread)) {}
Dispatcher::~Dispatcher() { impl_->Stop(); }
absl::Status Dispatcher::Join(
    const std::shared_ptr<WorkerLink>& link, const v1::Hello& hello,
    const std::function<void(const std::vector<v1::AttemptId>&)>& welcome) {
  return impl_->Join(link, hello, welcome);
}
void Dispatcher::AddCredit(const std::string& worker, const WorkerLink* link,
                           const v1::Credit& credit) {
  impl_->AddCredit(worker, link, credit);
}
void Dispatcher::Heard(const std::string& worker, WorkerLink* link,
                       const v1::Heartbeat& heartbeat) {
  impl_->Heard(worker, link, heartbeat);
}
void Dispatcher::Left(const std::string& worker, const WorkerLink* link) {
  impl_->Left(worker, link);
}
void Dispatcher::Reported(const std::string& worker, bool succeeded) {
  impl_->Reported(worker, succeeded);
}
void Dispatcher::HoldLeases(bool hold) { impl_->HoldLeases(hold); }
std::vector<v1::WorkerStatus> Dispatcher::Workers() const { return impl_->Workers(); }
std::vector<WorkerGroup> Dispatcher::WorkerGroups() const { return impl_->WorkerGroups(); }
ServerMetrics Dispatcher::Metrics() const { return impl_->Metrics(); }
void Dispatcher::Stop() { impl_->Stop(); }
SteadyTime Dispatcher::Work() { return impl_->Work(); }
void Dispatcher::OnWorkReady() { impl_->OnWorkReady(); }
void Dispatcher::OnDrains(const std::vector<v1::DrainOrder>& drains) { impl_->OnDrains(drains); }
std::vector<std::string> Dispatcher::ConnectedLike(const std::string& pattern) const {
  return impl_->ConnectedLike(pattern);
}
void Dispatcher::OnStop(const std::string& worker, const v1::AttemptId& attempt,
                        const std::string& reason) {
  impl_->OnStop(worker, attempt, reason);
}

}  // namespace parallax
