// The workers that a coordinator knows: their abilities, their credit, and whether they are alive.
//
// A worker is connected while it has a link. It is away after its stream broke, and lost after the
// reconnect grace, or if it is connected but silent for longer than a lease. It has left if it
// drained and closed its stream. Lost and left workers are shown for a while, then forgotten.
//
// Not thread-safe. The caller passes the time.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/base/system/clock.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/coordinator_server.h"
#include "coordinator/rpc/workers/conduct.h"
#include "coordinator/rpc/workers/why_waiting.h"
#include "coordinator/rpc/workers/worker_link.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

enum class Presence { kConnected, kAway, kLost, kLeft };

// A worker, its stream and its credit.
struct FleetWorker {
  WorkerFacts facts;
  v1::Hello hello;                   // Without `holding`.
  std::shared_ptr<WorkerLink> link;  // Null unless kConnected.
  Presence presence = Presence::kConnected;
  bool draining = false;
  int credit = 0;
  int ahead = 0;  // Part of the credit that is for slots that are still busy.
  SteadyTime ahead_since{};
  bool asking = false;        // A call to the queue for leases is under way.
  uint64_t served_round = 0;  // Last round of asking in which it got less than it asked for.
  SteadyTime wants_since{};
  SteadyTime heard{};
  SteadyTime away_since{};

  // Adds the credit of a message: jobs that the worker asks for.
  void AddCredit(const v1::Credit& more, SteadyTime now);
  // Returns the worker's credit without the part for slots that are probably still busy.
  int IdleSlots(SteadyTime now) const;
};

// The farm's slots by kind of job, for kinds whose jobs can be split.
using FarmByKind = std::map<std::string, FarmSlots>;

class Fleet {
 public:
  // `queue` must outlive the fleet.
  Fleet(const JobQueue& queue, double lease_s, double reconnect_grace_s);

  std::map<std::string, FleetWorker>& workers() { return workers_; }
  const std::map<std::string, FleetWorker>& workers() const { return workers_; }
  // Returns the worker; null unless `link` is its current one.
  FleetWorker* Present(const std::string& name, const WorkerLink* link);
  // Returns whether a Hello comes from the same process as the worker's last Hello.
  bool IsSameProcess(const v1::Hello& hello) const;

  // Closes the worker's link, because a newer stream with this name has arrived, from the same
  // worker or from another one with the same name.
  void DropLink(const v1::Hello& hello, SteadyTime now);
  // Adds a worker that has said Hello, or updates it, with its new link.
  void TakeIn(const std::shared_ptr<WorkerLink>& link, const v1::Hello& hello, SteadyTime now);
  // Notes that the worker's stream has ended. Returns true if the worker had drained and thus has
  // left, so that its leases must go to other workers.
  bool Break(FleetWorker& worker, SteadyTime now);
  // Notes the end of an attempt; see ConductBook.
  void Reported(const std::string& name, bool succeeded, SteadyTime now);
  // Returns how many jobs the queue may be asked for on this worker's behalf now.
  int TrustIn(const FleetWorker& worker, SteadyTime now) const;

  // Replaces the orders to drain. Workers whose names they match get no leases.
  void SetDrains(std::vector<v1::DrainOrder> drains) { drains_ = std::move(drains); }
  // Returns the pattern of an order that matches the worker; "" if none does.
  std::string DrainedBy(const std::string& name) const;
  std::vector<std::string> ConnectedLike(const std::string& pattern) const;
  // Returns whether the worker is connected and neither drains by itself nor by an order.
  bool TakesWork(const FleetWorker& worker) const;

  // Marks workers that were silent or away for too long as lost, and forgets those that were lost
  // or left long ago. Returns the workers that were lost since the last call.
  std::vector<std::string> CheckPresence(SteadyTime now);
  // Closes all links with `status`.
  void CloseAll(const absl::Status& status);

  FarmByKind SlotsByKind(SteadyTime now) const;
  // Returns the workers that may still get jobs, by their abilities. A worker that is away but not
  // lost counts as busy.
  std::vector<WorkerGroup> Groups(SteadyTime now) const;
  std::vector<v1::WorkerStatus> Statuses(SteadyTime now) const;
  // Sets the numbers of workers, slots and running jobs in `metrics`.
  void Count(ServerMetrics& metrics) const;

 private:
  int Running(const FleetWorker& worker) const;
  const char* StateName(const FleetWorker& worker, SteadyTime now) const;
  bool IsOverdue(const FleetWorker& worker, SteadyTime now) const;

  const JobQueue& queue_;
  const double lease_s_;
  const double grace_s_;
  std::map<std::string, FleetWorker> workers_;
  ConductBook conduct_;  // Has entries of workers_ only.
  std::vector<v1::DrainOrder> drains_;
  int64_t lost_ = 0;
};

}  // namespace parallax
