#include "coordinator/rpc/dispatcher.h"

#include <pthread.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <tuple>

#include "common/base/log.h"
#include "coordinator/queue/histogram.h"
#include "coordinator/rpc/ask_window.h"
#include "coordinator/rpc/conduct.h"
#include "coordinator/rpc/reply_size.h"
#include "coordinator/rpc/seconds.h"
#include "coordinator/rpc/validation.h"

namespace parallax {
namespace {

constexpr int kMostAskedAtOnce = 64;  // Jobs of one worker in one call.
// A wake-up that went missing costs at most this.
constexpr double kLookAgain_s = 1;
// Credit for a slot that was about to become free: it is by now.
constexpr double kAheadIsIdle_s = 2;
// Who has gone is shown for so long, the latest of them.
constexpr double kForgetWorker_s = 300;
constexpr size_t kMostGoneWorkers = 20;

enum class Presence { kConnected, kAway, kLost, kLeft };

struct Worker {
  WorkerFacts facts;
  v1::Hello hello;
  std::shared_ptr<WorkerLink> link;  // Null unless kConnected.
  Presence presence = Presence::kConnected;
  bool draining = false;
  int credit = 0;
  int ahead = 0;  // Of the credit: for slots that are still busy.
  SteadyTime ahead_since{};
  bool asking = false;
  uint64_t served_round = 0;  // Got less than it asked for in this round.
  SteadyTime wants_since{};
  SteadyTime heard{};
  SteadyTime away_since{};
};

using ClassKey = std::tuple<std::vector<std::string>, int64_t, std::vector<std::string>>;
ClassKey ClassOf(const WorkerFacts& facts) { return {facts.kinds, facts.memory_mb, facts.tags}; }

// What the queue's thread leaves for the dispatcher's. Outlives both while a call is under way.
struct Note {
  enum Kind { kLeases, kStop } kind;
  std::string worker;
  std::weak_ptr<WorkerLink> link;  // That asked.
  ClassKey of_class;
  uint64_t round = 0;
  int asked = 0;
  absl::StatusOr<std::vector<v1::Lease>> leases = std::vector<v1::Lease>();
  v1::AttemptId attempt;
  std::string reason;
};
struct Outgoing {
  std::shared_ptr<WorkerLink> link;
  v1::CoordinatorMessage message;
};

struct Notes {
  std::mutex mu;
  std::condition_variable changed;
  // Guarded by mu.
  std::deque<Note> notes;
  bool work_ready = false;
  bool poked = false;
  int calls_in_flight = 0;
};

}  // namespace

class Dispatcher::Impl {
 public:
  Impl(JobQueue& queue, TaskPool& pool, Clock& clock, double reconnect_grace_s)
      : queue_(queue),
        pool_(pool),
        clock_(clock),
        lease_s_(queue.lease_s()),
        grace_s_(std::min(reconnect_grace_s, queue.lease_s())) {
    thread_ = std::thread([this] { Loop(); });
  }

  absl::Status Join(const std::shared_ptr<WorkerLink>& link, const v1::Hello& hello,
                    const std::function<void(const std::vector<v1::AttemptId>&)>& welcome) {
    bool same_process = false;
    {
      std::lock_guard lock(mu_);
      if (joining_.count(hello.name()) > 0) {
        return absl::AbortedError("worker " + hello.name() + " is already being taken in");
      }
      if (workers_.count(hello.name()) == 0 && workers_.size() + joining_.size() >= kMostWorkers) {
        return absl::ResourceExhaustedError("no room for worker " + hello.name() +
                                            ": a coordinator has at most " +
                                            std::to_string(kMostWorkers));
      }
      joining_.insert(hello.name());
      DropLink(hello.name());
      const auto known = workers_.find(hello.name());
      same_process = known != workers_.end() && !hello.instance().empty() &&
                     known->second.hello.instance() == hello.instance();
    }
    auto adopted =
        queue_.Adopt(hello.name(), {hello.holding().begin(), hello.holding().end()}, same_process);
    std::lock_guard lock(mu_);
    joining_.erase(hello.name());
    if (!adopted.ok()) return adopted.status();
    if (stopping_) return absl::UnavailableError("the coordinator is stopping");
    welcome(*adopted);
    Worker& worker = workers_[hello.name()];
    worker = Worker();
    worker.facts = FactsOf(hello);
    worker.hello = hello;
    worker.hello.clear_holding();
    worker.link = link;
    worker.heard = clock_.Steady();
    LogInfo("worker connected", {{"worker", hello.name()},
                                 {"slots", hello.slots()},
                                 {"version", hello.version()},
                                 {"holding", hello.holding_size()},
                                 {"adopted", adopted->size()}});
    return absl::OkStatus();
  }

  void AddCredit(const std::string& name, const WorkerLink* link, const v1::Credit& credit) {
    std::lock_guard lock(mu_);
    Worker* worker = Present(name, link);
    if (worker == nullptr) return;
    worker->heard = clock_.Steady();
    if (worker->credit == 0) worker->wants_since = clock_.Steady();
    worker->credit = std::min(worker->credit + credit.jobs(), kMaxCredit);
    worker->ahead = std::min(worker->ahead + credit.ahead(), worker->credit);
    if (credit.ahead() > 0) worker->ahead_since = clock_.Steady();
    worker->served_round = 0;  // New credit asks anew.
    Poke();
  }

  void Heard(const std::string& name, const WorkerLink* link, const v1::Heartbeat& heartbeat) {
    std::lock_guard lock(mu_);
    Worker* worker = Present(name, link);
    if (worker == nullptr) return;
    worker->heard = clock_.Steady();
    worker->draining = heartbeat.draining();
  }

  void Left(const std::string& name, const WorkerLink* link) {
    std::lock_guard lock(mu_);
    Worker* worker = Present(name, link);
    if (worker == nullptr) return;
    worker->link.reset();
    worker->credit = 0;
    worker->away_since = clock_.Steady();
    // Who drained and hung up said all there was to say.
    worker->presence = worker->draining ? Presence::kLeft : Presence::kAway;
    LogInfo(worker->draining ? "worker left" : "worker's stream broke", {{"worker", name}});
    if (worker->draining) Forfeit(name);
  }

  void Reported(const std::string& name, bool succeeded) {
    std::lock_guard lock(mu_);
    const SteadyTime now = clock_.Steady();
    if (workers_.count(name) == 0) return;  // Nobody's report; or it has gone.
    if (conduct_.Reported(name, succeeded, now)) {
      LogWarning("worker fails everything; suspended",
                 {{"worker", name}, {"seconds", conduct_.SuspendedFor(name, now)}});
    }
  }

  std::vector<v1::WorkerStatus> Workers() const {
    std::lock_guard lock(mu_);
    std::vector<v1::WorkerStatus> all;
    for (const auto& [name, worker] : workers_) {
      v1::WorkerStatus& status = all.emplace_back();
      status.set_name(name);
      *status.mutable_kinds() = worker.hello.kinds();
      status.set_slots(worker.hello.slots());
      status.set_running(Running(name, worker));
      status.set_state(conduct_.SuspendedFor(name, clock_.Steady()) > 0 &&
                               worker.presence == Presence::kConnected
                           ? "suspended"
                           : StateName(name, worker));
      status.set_last_heard_s(SecondsBetween(worker.heard, clock_.Steady()));
      status.set_version(worker.hello.version());
    }
    return all;
  }

  ServerMetrics Metrics() const {
    std::lock_guard lock(mu_);
    ServerMetrics metrics;
    for (const auto& [name, worker] : workers_) {
      if (worker.presence != Presence::kConnected) continue;
      ++metrics.workers_connected;
      metrics.slots += worker.hello.slots();
      metrics.running += Running(name, worker);
    }
    metrics.leases = leases_;
    metrics.workers_lost = workers_lost_;
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
      Poke();
    }
    thread_.join();
    std::lock_guard lock(mu_);
    for (auto& [name, worker] : workers_) {
      if (worker.link == nullptr) continue;
      worker.link->Close(absl::UnavailableError("the coordinator is stopping"), false);
      worker.link.reset();
    }
  }

  void OnWorkReady() {
    std::lock_guard lock(notes_->mu);
    notes_->work_ready = true;
    notes_->changed.notify_one();
  }

  void OnStop(const std::string& worker, const v1::AttemptId& attempt, const std::string& reason) {
    Note note;
    note.kind = Note::kStop;
    note.worker = worker;
    note.attempt = attempt;
    note.reason = reason;
    std::lock_guard lock(notes_->mu);
    notes_->notes.push_back(std::move(note));
    notes_->changed.notify_one();
  }

 private:
  static WorkerFacts FactsOf(const v1::Hello& hello) {
    WorkerFacts facts;
    facts.name = hello.name();
    facts.kinds.assign(hello.kinds().begin(), hello.kinds().end());
    std::sort(facts.kinds.begin(), facts.kinds.end());
    facts.memory_mb = hello.memory_mb();
    facts.tags.assign(hello.tags().begin(), hello.tags().end());
    std::sort(facts.tags.begin(), facts.tags.end());
    return facts;
  }

  // Slots that are busy: of the leases that it holds, those ahead of a free slot wait.
  int Running(const std::string& name, const Worker& worker) const {
    if (worker.presence == Presence::kLost || worker.presence == Presence::kLeft) return 0;
    return std::min(queue_.HeldBy(name), worker.hello.slots());
  }

  const char* StateName(const std::string& name, const Worker& worker) const {
    switch (worker.presence) {
      case Presence::kConnected:
        return worker.draining ? "draining" : Running(name, worker) > 0 ? "busy" : "idle";
      case Presence::kAway:
        return "away";
      case Presence::kLost:
        return "lost";
      case Presence::kLeft:
        return "left";
    }
    return "";
  }

  // ---- All below require mu_ unless said otherwise ----
  // How many jobs it may be asked for now.
  int TrustIn(const std::string& name, const Worker& worker, SteadyTime now) const {
    return conduct_.TrustIn(name, worker.credit, queue_.HeldBy(name), now);
  }

  Worker* Present(const std::string& name, const WorkerLink* link) {
    const auto found = workers_.find(name);
    if (found == workers_.end() || found->second.link.get() != link) return nullptr;
    return &found->second;
  }

  // A newer stream of the same name came: it is the same worker, or one that took its name.
  void DropLink(const std::string& name) {
    const auto found = workers_.find(name);
    if (found == workers_.end() || found->second.link == nullptr) return;
    found->second.link->Close(
        absl::AlreadyExistsError("another worker named " + name + " has connected"), false);
    found->second.link.reset();
    found->second.presence = Presence::kAway;
    found->second.away_since = clock_.Steady();
    found->second.credit = 0;
  }

  void Poke() {
    std::lock_guard lock(notes_->mu);
    notes_->poked = true;
    notes_->changed.notify_one();
  }

  // Its leases are nobody's now. The commit is waited for on the pool.
  void Forfeit(const std::string& name) {
    pool_.Run([queue = &queue_, name] {
      const auto lost = queue->WorkerLost(name);
      if (!lost.ok()) {
        LogError("leases of a lost worker stay until they expire",
                 {{"worker", name}, {"error", lost.status()}});
      } else if (*lost > 0) {
        LogWarning("leases of a lost worker are given to others",
                   {{"worker", name}, {"leases", *lost}});
      }
    });
  }

  // ---- The dispatcher's thread ----
  void Loop() {
    pthread_setname_np(pthread_self(), "dispatcher");
    SteadyTime look_at = SecondsAfter(clock_.Steady(), kLookAgain_s);
    SteadyTime check_at = clock_.Steady();
    const double check_every_s = std::min(0.25, std::min(lease_s_, grace_s_) / 4);
    while (true) {
      std::deque<Note> notes;
      const bool work_ready = TakeNotes(std::min(look_at, check_at), &notes);
      std::vector<Outgoing> outbox;
      const bool over = Turn(notes, work_ready, check_every_s, &look_at, &check_at, &outbox);
      // Hundreds of writes to sockets: nobody who brings credit or a heartbeat waits for them.
      for (Outgoing& outgoing : outbox) outgoing.link->Send(std::move(outgoing.message));
      if (over) return;
    }
  }

  // What there is to do at one time; true when it was the last.
  bool Turn(std::deque<Note>& notes, bool work_ready, double check_every_s, SteadyTime* look_at,
            SteadyTime* check_at, std::vector<Outgoing>* outbox) {
    std::lock_guard lock(mu_);
    for (Note& note : notes) Handle(note, outbox);
    const SteadyTime now = clock_.Steady();
    if (now >= *look_at) {
      *look_at = SecondsAfter(now, kLookAgain_s);
      work_ready = true;
    }
    if (work_ready) NewRound(now);
    if (now >= *check_at) {
      *check_at = SecondsAfter(now, check_every_s);
      CheckPresence(now);
    }
    if (stopping_) return NothingUnderWay();
    Ask();
    return false;
  }

  // Waits for notes or `deadline`; true when work may be ready. Without mu_.
  bool TakeNotes(SteadyTime deadline, std::deque<Note>* notes) {
    std::unique_lock lock(notes_->mu);
    notes_->changed.wait_until(lock, deadline, [this] {
      return !notes_->notes.empty() || notes_->work_ready || notes_->poked;
    });
    notes->swap(notes_->notes);
    notes_->poked = false;
    return std::exchange(notes_->work_ready, false);
  }

  bool NothingUnderWay() {
    std::lock_guard lock(notes_->mu);
    return notes_->calls_in_flight == 0 && notes_->notes.empty();
  }

  void NewRound(SteadyTime now) {
    ++round_;
    for (auto& [key, window] : windows_) window.NewRound();
    // For the latency: a worker that waited for work can't have been served before there was some.
    for (auto& [name, worker] : workers_) {
      if (!worker.asking && worker.credit > 0 && worker.served_round != 0) worker.wants_since = now;
    }
  }

  void Handle(Note& note, std::vector<Outgoing>* outbox) {
    if (note.kind == Note::kStop) {
      SendStop(note, outbox);
    } else {
      HandleLeases(note, outbox);
    }
  }

  void SendStop(const Note& note, std::vector<Outgoing>* outbox) {
    const auto found = workers_.find(note.worker);
    if (found == workers_.end() || found->second.link == nullptr) return;
    v1::CoordinatorMessage message;
    *message.mutable_stop()->mutable_attempt() = note.attempt;
    message.mutable_stop()->set_reason(note.reason);
    outbox->push_back({found->second.link, std::move(message)});
  }

  void HandleLeases(Note& note, std::vector<Outgoing>* outbox) {
    if (!note.leases.ok()) {
      LogError("no leases from the queue", {{"error", note.leases.status()}});
      note.leases = std::vector<v1::Lease>();
    }
    const int got = static_cast<int>(note.leases->size());
    windows_[note.of_class].Answered(got, note.round == round_);
    const std::shared_ptr<WorkerLink> link = note.link.lock();
    Worker* worker = link == nullptr ? nullptr : Present(note.worker, link.get());
    if (worker == nullptr || stopping_) {
      if (worker != nullptr) worker->asking = false;
      return GiveBack(note);
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

  // Leased to a worker that has gone meanwhile: READY again, without blame.
  void GiveBack(const Note& note) {
    for (const v1::Lease& lease : *note.leases) {
      pool_.Run([queue = &queue_, worker = note.worker, attempt = lease.attempt()] {
        const auto outcome = queue->HandBack(worker, attempt, "worker gone before the lease");
        if (!outcome.ok()) LogWarning("lease not handed back", {{"error", outcome.status()}});
      });
    }
  }

  // In turn, so that the last in the alphabet is not the last to eat.
  void Ask() {
    if (workers_.empty()) return;
    const SteadyTime now = clock_.Steady();
    std::optional<Farm> farm;
    auto it = workers_.upper_bound(last_asked_);
    for (size_t i = 0; i < workers_.size(); ++i, ++it) {
      if (it == workers_.end()) it = workers_.begin();
      Worker& worker = it->second;
      if (worker.link == nullptr || worker.draining || worker.asking || worker.credit <= 0 ||
          worker.served_round == round_ || TrustIn(it->first, worker, now) <= 0) {
        continue;
      }
      const ClassKey key = ClassOf(worker.facts);
      AskWindow& window = windows_[key];
      if (!window.IsOpen()) continue;
      window.Asked();
      if (!farm) farm = LookAtFarm();
      AskFor(worker, key, *farm);
      for (const std::string& kind : worker.facts.kinds) {
        const auto slots = farm->find(kind);
        if (slots != farm->end()) slots->second.idle -= IdleSlots(worker);
      }
      last_asked_ = it->first;
    }
  }

  // What splitting is decided by: slots by kind of job that can be split.
  using Farm = std::map<std::string, FarmSlots>;
  int IdleSlots(const Worker& worker) const {
    const bool busy_still = SecondsBetween(worker.ahead_since, clock_.Steady()) < kAheadIsIdle_s;
    return worker.credit - (busy_still ? worker.ahead : 0);
  }
  Farm LookAtFarm() const {
    Farm farm;
    const KindRegistry& kinds = queue_.kinds();
    for (size_t i = 0; i < kinds.size(); ++i) {
      if (kinds.at(i).traits().can_split) farm[kinds.at(i).name()];
    }
    for (const auto& [name, worker] : workers_) {
      if (worker.link == nullptr || worker.draining) continue;
      for (const std::string& kind : worker.facts.kinds) {
        const auto slots = farm.find(kind);
        if (slots == farm.end()) continue;
        slots->second.all += worker.hello.slots();
        // Who has asked already was counted when it did.
        if (!worker.asking) slots->second.idle += IdleSlots(worker);
      }
    }
    return farm;
  }

  void AskFor(Worker& worker, const ClassKey& key, const Farm& farm) {
    worker.asking = true;
    worker.facts.farm = farm;
    const int jobs =
        std::min(TrustIn(worker.facts.name, worker, clock_.Steady()), kMostAskedAtOnce);
    Note note;
    note.kind = Note::kLeases;
    note.worker = worker.facts.name;
    note.link = worker.link;
    note.of_class = key;
    note.round = round_;
    note.asked = jobs;
    {
      std::lock_guard lock(notes_->mu);
      ++notes_->calls_in_flight;
    }
    queue_.LeaseAsync(worker.facts, jobs,
                      [notes = notes_, note = std::move(note)](
                          absl::StatusOr<std::vector<v1::Lease>> leases) mutable {
                        note.leases = std::move(leases);
                        std::lock_guard lock(notes->mu);
                        --notes->calls_in_flight;
                        notes->notes.push_back(std::move(note));
                        notes->changed.notify_one();
                      });
  }

  static bool IsGone(const Worker& worker) {
    return worker.presence == Presence::kLost || worker.presence == Presence::kLeft;
  }

  void CheckPresence(SteadyTime now) {
    std::vector<std::pair<SteadyTime, std::string>> gone;
    for (auto& [name, worker] : workers_) {
      if (worker.presence == Presence::kConnected && SecondsBetween(worker.heard, now) > lease_s_) {
        LogWarning("worker is silent", {{"worker", name}, {"lease_s", lease_s_}});
        worker.link->Close(absl::DeadlineExceededError("no heartbeat within the lease"), true);
        worker.link.reset();
        Lose(name, worker);
      } else if (worker.presence == Presence::kAway &&
                 SecondsBetween(worker.away_since, now) > grace_s_) {
        Lose(name, worker);
      }
      if (IsGone(worker)) gone.emplace_back(worker.heard, name);
    }
    std::sort(gone.rbegin(), gone.rend());
    for (size_t i = 0; i < gone.size(); ++i) {
      const auto& [heard, name] = gone[i];
      if (i < kMostGoneWorkers && SecondsBetween(heard, now) <= kForgetWorker_s) continue;
      conduct_.Forget(name);
      workers_.erase(name);
    }
  }

  void Lose(const std::string& name, Worker& worker) {
    worker.presence = Presence::kLost;
    worker.credit = 0;
    ++workers_lost_;
    LogWarning("worker lost", {{"worker", name}});
    Forfeit(name);
  }

  JobQueue& queue_;
  TaskPool& pool_;
  Clock& clock_;
  const double lease_s_;
  const double grace_s_;
  const std::shared_ptr<Notes> notes_ = std::make_shared<Notes>();

  mutable std::mutex mu_;  // Before Notes::mu.
  // Guarded by mu_.
  std::map<std::string, Worker> workers_;
  ConductBook conduct_;  // Of workers_.
  std::map<ClassKey, AskWindow> windows_;
  std::set<std::string> joining_;
  std::string last_asked_;
  uint64_t round_ = 1;  // 0: in no round.
  bool stopping_ = false;
  int64_t leases_ = 0;
  int64_t workers_lost_ = 0;
  CountHistogram latency_s_{{0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5}};
  double latency_sum_s_ = 0;

  std::thread thread_;
};

Dispatcher::Dispatcher(JobQueue& queue, TaskPool& pool, Clock& clock, double reconnect_grace_s)
    : impl_(std::make_unique<Impl>(queue, pool, clock, reconnect_grace_s)) {}
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
void Dispatcher::Heard(const std::string& worker, const WorkerLink* link,
                       const v1::Heartbeat& heartbeat) {
  impl_->Heard(worker, link, heartbeat);
}
void Dispatcher::Left(const std::string& worker, const WorkerLink* link) {
  impl_->Left(worker, link);
}
void Dispatcher::Reported(const std::string& worker, bool succeeded) {
  impl_->Reported(worker, succeeded);
}
std::vector<v1::WorkerStatus> Dispatcher::Workers() const { return impl_->Workers(); }
ServerMetrics Dispatcher::Metrics() const { return impl_->Metrics(); }
void Dispatcher::Stop() { impl_->Stop(); }
void Dispatcher::OnWorkReady() { impl_->OnWorkReady(); }
void Dispatcher::OnStop(const std::string& worker, const v1::AttemptId& attempt,
                        const std::string& reason) {
  impl_->OnStop(worker, attempt, reason);
}

}  // namespace parallax
