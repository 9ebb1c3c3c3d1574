// The workers that a coordinator knows: what each can take and has asked for, and whether it is
// still there.
//
// A worker is connected while it has a link. When its stream breaks it is away; after the reconnect
// grace it is lost, as is one that is connected but silent for longer than a lease. One that
// drained and hung up has left. Lost and left workers are shown for a while, then forgotten.
//
// Not thread-safe. Times are the caller's.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/conduct.h"
#include "coordinator/rpc/coordinator_server.h"
#include "coordinator/rpc/worker_link.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

enum class Presence { kConnected, kAway, kLost, kLeft };

struct FleetWorker {
  WorkerFacts facts;
  v1::Hello hello;                   // Without what it held.
  std::shared_ptr<WorkerLink> link;  // Null unless kConnected.
  Presence presence = Presence::kConnected;
  bool draining = false;
  int credit = 0;
  int ahead = 0;  // Part of the credit: for slots that are still busy.
  SteadyTime ahead_since{};
  bool asking = false;        // A call for leases is under way.
  uint64_t served_round = 0;  // Got less than it asked for in this round of asking.
  SteadyTime wants_since{};
  SteadyTime heard{};
  SteadyTime away_since{};

  void AddCredit(const v1::Credit& more, SteadyTime now);
  // Its credit without the part for slots that are likely busy still.
  int IdleSlots(SteadyTime now) const;
};

// Slots of the farm by kind of job, for the kinds whose jobs can be split.
using FarmByKind = std::map<std::string, FarmSlots>;

class Fleet {
 public:
  // `queue` outlives the fleet.
  Fleet(const JobQueue& queue, double lease_s, double reconnect_grace_s);

  std::map<std::string, FleetWorker>& workers() { return workers_; }
  const std::map<std::string, FleetWorker>& workers() const { return workers_; }
  // Null unless `link` is the present one of the worker.
  FleetWorker* Present(const std::string& name, const WorkerLink* link);
  // Whether the process that says hello is the one that did before.
  bool IsSameProcess(const v1::Hello& hello) const;

  // A newer stream of the name comes, of the same worker or of one that took its name: the link is
  // closed.
  void DropLink(const std::string& name, SteadyTime now);
  void TakeIn(const std::shared_ptr<WorkerLink>& link, const v1::Hello& hello, SteadyTime now);
  // Its stream ended. True if it has left and its leases are to be given to others.
  bool Break(FleetWorker& worker, SteadyTime now);
  // An attempt of this worker's has ended; see ConductBook.
  void Reported(const std::string& name, bool succeeded, SteadyTime now);
  // How many jobs it may be asked for now.
  int TrustIn(const FleetWorker& worker, SteadyTime now) const;

  // These are now the orders to drain; who they name gets no leases.
  void SetDrains(std::vector<v1::DrainOrder> drains) { drains_ = std::move(drains); }
  // The pattern of an order that names the worker; "" if none does.
  std::string DrainedBy(const std::string& name) const;
  std::vector<std::string> ConnectedLike(const std::string& pattern) const;
  // It is there, doesn't drain by itself and isn't ordered to.
  bool TakesWork(const FleetWorker& worker) const;

  // Finds who is silent or away for too long and forgets who has gone long ago. Returns the workers
  // that are lost since the last call.
  std::vector<std::string> CheckPresence(SteadyTime now);
  void CloseAll(const absl::Status& status);

  FarmByKind SlotsByKind(SteadyTime now) const;
  std::vector<v1::WorkerStatus> Statuses(SteadyTime now) const;
  // Sets the numbers of workers, slots and running jobs.
  void Count(ServerMetrics& metrics) const;

 private:
  int Running(const FleetWorker& worker) const;
  const char* StateName(const FleetWorker& worker, SteadyTime now) const;
  bool IsOverdue(const FleetWorker& worker, SteadyTime now) const;

  const JobQueue& queue_;
  const double lease_s_;
  const double grace_s_;
  std::map<std::string, FleetWorker> workers_;
  ConductBook conduct_;  // Entries of workers_.
  std::vector<v1::DrainOrder> drains_;
  int64_t lost_ = 0;
};

}  // namespace parallax
