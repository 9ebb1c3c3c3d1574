#include "coordinator/rpc/workers/fleet.h"

#include <fnmatch.h>

#include <algorithm>
#include <string_view>
#include <tuple>

#include "common/base/seconds.h"
#include "common/base/status.h"
#include "common/base/system/log.h"
#include "coordinator/rpc/validation.h"

namespace parallax {
namespace {

// Credit for a slot that was about to become free: after this long it is.
constexpr double kAheadIsIdle_s = 2;
// A worker that has gone is listed for this long, the latest ones only.
constexpr double kForgetWorker_s = 300;
constexpr size_t kMostGoneWorkers = 20;

WorkerFacts FactsOf(const v1::Hello& hello) {
  WorkerFacts facts;
  facts.name = hello.name();
  facts.machine = hello.machine();
  facts.kinds.assign(hello.kinds().begin(), hello.kinds().end());
  std::sort(facts.kinds.begin(), facts.kinds.end());
  facts.memory_mb = hello.memory_mb();
  facts.tags.assign(hello.tags().begin(), hello.tags().end());
  std::sort(facts.tags.begin(), facts.tags.end());
  return facts;
}

// Names have no character that means more than itself but * and ?; see CheckDrain.
bool Matches(const std::string& pattern, const std::string& name) {
  return ::fnmatch(pattern.c_str(), name.c_str(), FNM_NOESCAPE) == 0;
}

bool IsGone(const FleetWorker& worker) {
  return worker.presence == Presence::kLost || worker.presence == Presence::kLeft;
}

}  // namespace

void FleetWorker::AddCredit(const v1::Credit& more, SteadyTime now) {
  heard = now;
  if (credit == 0) wants_since = now;
  credit = std::min(credit + more.jobs(), kMaxCredit);
  ahead = std::min(ahead + more.ahead(), credit);
  if (more.ahead() > 0) ahead_since = now;
  served_round = 0;  // New credit asks anew.
}

int FleetWorker::IdleSlots(SteadyTime now) const {
  const bool busy_still = SecondsBetween(ahead_since, now) < kAheadIsIdle_s;
  return credit - (busy_still ? ahead : 0);
}

Fleet::Fleet(const JobQueue& queue, double lease_s, double reconnect_grace_s)
    : queue_(queue), lease_s_(lease_s), grace_s_(reconnect_grace_s) {}

FleetWorker* Fleet::Present(const std::string& name, const WorkerLink* link) {
  const auto found = workers_.find(name);
  if (found == workers_.end() || found->second.link.get() != link) return nullptr;
  return &found->second;
}

bool Fleet::IsSameProcess(const v1::Hello& hello) const {
  const auto known = workers_.find(hello.name());
  return known != workers_.end() && !hello.instance().empty() &&
         known->second.hello.instance() == hello.instance();
}

// A hello may come after a newer one of its process: its stream broke while it waited here. If the
// newer stream ended with an error that no retry mends, the worker would end itself.
void Fleet::DropLink(const v1::Hello& hello, SteadyTime now) {
  const auto found = workers_.find(hello.name());
  if (found == workers_.end() || found->second.link == nullptr) return;
  found->second.link->Close(
      IsSameProcess(hello) ? Unavailable("worker {} has another stream", hello.name())
                           : AlreadyExists("another worker named {} has connected", hello.name()),
      false);
  found->second.link.reset();
  found->second.presence = Presence::kAway;
  found->second.away_since = now;
  found->second.credit = 0;
}

void Fleet::TakeIn(const std::shared_ptr<WorkerLink>& link, const v1::Hello& hello,
                   SteadyTime now) {
  FleetWorker& worker = workers_[hello.name()];
  worker = FleetWorker();
  worker.facts = FactsOf(hello);
  worker.hello = hello;
  worker.hello.clear_holding();
  worker.link = link;
  worker.heard = now;
}

bool Fleet::Break(FleetWorker& worker, SteadyTime now) {
  worker.link.reset();
  worker.credit = 0;
  worker.away_since = now;
  // A worker that drained and then ended its stream has left for good.
  worker.presence = worker.draining ? Presence::kLeft : Presence::kAway;
  LogInfo(worker.draining ? "worker left" : "worker's stream broke",
          {{"worker", worker.facts.name}});
  return worker.draining;
}

void Fleet::Reported(const std::string& name, bool succeeded, SteadyTime now) {
  if (workers_.count(name) == 0) return;  // The worker is unknown, or has gone.
  if (conduct_.Reported(name, succeeded, now)) {
    LogWarning("worker fails everything; suspended",
               {{"worker", name}, {"seconds", conduct_.SuspendedFor(name, now)}});
  }
}

int Fleet::TrustIn(const FleetWorker& worker, SteadyTime now) const {
  const std::string& name = worker.facts.name;
  return conduct_.TrustIn(name, worker.credit, queue_.HeldBy(name), now);
}

std::string Fleet::DrainedBy(const std::string& name) const {
  for (const v1::DrainOrder& drain : drains_) {
    if (Matches(drain.pattern(), name)) return drain.pattern();
  }
  return "";
}

std::vector<std::string> Fleet::ConnectedLike(const std::string& pattern) const {
  std::vector<std::string> names;
  for (const auto& [name, worker] : workers_) {
    if (worker.link != nullptr && Matches(pattern, name)) names.push_back(name);
  }
  return names;
}

bool Fleet::TakesWork(const FleetWorker& worker) const {
  return worker.link != nullptr && !worker.draining && DrainedBy(worker.facts.name).empty();
}

bool Fleet::IsOverdue(const FleetWorker& worker, SteadyTime now) const {
  switch (worker.presence) {
    case Presence::kConnected:
      return SecondsBetween(worker.heard, now) > lease_s_;
    case Presence::kAway:
      return SecondsBetween(worker.away_since, now) > grace_s_;
    default:
      return false;
  }
}

std::vector<std::string> Fleet::CheckPresence(SteadyTime now) {
  std::vector<std::string> lost;
  std::vector<std::pair<SteadyTime, std::string>> gone;
  for (auto& [name, worker] : workers_) {
    if (IsOverdue(worker, now)) {
      if (worker.link != nullptr) {
        LogWarning("worker is silent", {{"worker", name}, {"lease_s", lease_s_}});
        worker.link->Close(DeadlineExceeded("no heartbeat within the lease"), true);
        worker.link.reset();
      }
      worker.presence = Presence::kLost;
      worker.credit = 0;
      LogWarning("worker lost", {{"worker", name}});
      lost.push_back(name);
    }
    if (IsGone(worker)) gone.emplace_back(worker.heard, name);
  }
  lost_ += static_cast<int64_t>(lost.size());
  std::sort(gone.rbegin(), gone.rend());
  for (size_t i = 0; i < gone.size(); ++i) {
    const auto& [heard, name] = gone[i];
    if (i < kMostGoneWorkers && SecondsBetween(heard, now) <= kForgetWorker_s) continue;
    conduct_.Forget(name);
    workers_.erase(name);
  }
  return lost;
}

void Fleet::CloseAll(const absl::Status& status) {
  for (auto& [name, worker] : workers_) {
    if (worker.link == nullptr) continue;
    worker.link->Close(status, false);
    worker.link.reset();
  }
}

FarmByKind Fleet::SlotsByKind(SteadyTime now) const {
  FarmByKind farm;
  const KindRegistry& kinds = queue_.kinds();
  for (size_t i = 0; i < kinds.size(); ++i) {
    if (kinds.at(i).traits().can_split) farm[kinds.at(i).name()];
  }
  for (const auto& [name, worker] : workers_) {
    if (!TakesWork(worker)) continue;
    for (const std::string& kind : worker.facts.kinds) {
      const auto slots = farm.find(kind);
      if (slots == farm.end()) continue;
      slots->second.all += worker.hello.slots();
      // A worker that has asked already was counted when it asked.
      if (!worker.asking) slots->second.idle += worker.IdleSlots(now);
    }
  }
  return farm;
}

std::vector<WorkerGroup> Fleet::Groups(SteadyTime now) const {
  std::map<std::tuple<std::vector<std::string>, std::vector<std::string>, int64_t>, WorkerGroup>
      groups;
  for (const auto& [name, worker] : workers_) {
    if (IsGone(worker)) continue;
    const WorkerFacts& facts = worker.facts;
    WorkerGroup& group = groups[{facts.kinds, facts.tags, facts.memory_mb}];
    const std::string_view state = StateName(worker, now);
    if (state == "suspended") {
      ++group.suspended;
    } else if (state == "draining" || state == "drained") {
      ++group.drained;
    } else if (state == "away" || Running(worker) >= worker.hello.slots()) {
      ++group.busy;
    } else {
      ++group.free;
    }
  }
  std::vector<WorkerGroup> all;
  for (auto& [abilities, group] : groups) {
    std::tie(group.kinds, group.tags, group.memory_mb) = abilities;
    all.push_back(std::move(group));
  }
  return all;
}

// Busy slots: leases beyond the slots wait for a free one.
int Fleet::Running(const FleetWorker& worker) const {
  if (IsGone(worker)) return 0;
  return std::min(queue_.HeldBy(worker.facts.name), worker.hello.slots());
}

const char* Fleet::StateName(const FleetWorker& worker, SteadyTime now) const {
  switch (worker.presence) {
    case Presence::kConnected:
      if (conduct_.SuspendedFor(worker.facts.name, now) > 0) return "suspended";
      if (worker.draining) return "draining";
      if (!DrainedBy(worker.facts.name).empty())
        return Running(worker) > 0 ? "draining" : "drained";
      return Running(worker) > 0 ? "busy" : "idle";
    case Presence::kAway:
      return "away";
    case Presence::kLost:
      return "lost";
    case Presence::kLeft:
      return "left";
  }
  return "";
}

std::vector<v1::WorkerStatus> Fleet::Statuses(SteadyTime now) const {
  std::vector<v1::WorkerStatus> all;
  for (const auto& [name, worker] : workers_) {
    v1::WorkerStatus& status = all.emplace_back();
    status.set_name(name);
    *status.mutable_kinds() = worker.hello.kinds();
    status.set_slots(worker.hello.slots());
    status.set_running(Running(worker));
    status.set_state(StateName(worker, now));
    status.set_last_heard_s(SecondsBetween(worker.heard, now));
    status.set_version(worker.hello.version());
    status.set_drained_by(DrainedBy(name));
  }
  return all;
}

void Fleet::Count(ServerMetrics& metrics) const {
  for (const auto& [name, worker] : workers_) {
    if (worker.presence != Presence::kConnected) continue;
    ++metrics.workers_connected;
    metrics.slots += worker.hello.slots();
    metrics.running += Running(worker);
  }
  metrics.workers_lost = lost_;
}

}  // namespace parallax
