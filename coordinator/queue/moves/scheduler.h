// Chooses jobs for workers, leases and splits them; policy.h has the decisions. Remembers workers:
// which are around, on which machines, and which groups are warm there. The memory is forgotten at
// a restart.
//
// Used by the writing thread only. Errors of all functions: those of the database; kNotFound for a
// kind that is not registered.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/commands/policy.h"
#include "coordinator/queue/moves/job_moves.h"
#include "coordinator/queue/moves/waiters.h"

namespace parallax {

class Scheduler {
 public:
  // All arguments must outlive the object.
  Scheduler(Tables& tables, JobMoves& jobs, Waiters& waiters)
      : tables_(tables), jobs_(jobs), waiters_(waiters) {}

  // Leases up to `max_jobs` jobs; see JobQueue::Lease.
  absl::StatusOr<std::vector<GrantedLease>> Lease(const WorkerFacts& worker, int max_jobs);

  // Note that a worker was heard of, or that it is gone.
  void NoteSeen(const std::string& worker) { workers_[worker].seen_s = tables_.SteadySeconds(); }
  void NoteGone(const std::string& worker) {
    workers_.erase(worker);
    abilities_.erase(worker);
  }
  bool Knows(const std::string& worker) const { return workers_.count(worker) > 0; }
  size_t workers() const { return workers_.size(); }
  // Returns the machine of a worker; its own name if that is not known.
  std::string MachineOf(const std::string& worker) const;
  // Returns a worker's memory in MB; 0 if it is not known.
  int64_t MemoryOf(const std::string& worker) const;
  // Returns the largest memory in MB of the workers that take such jobs and have their tags; 0 if
  // none is known.
  int64_t LargestMemory(const ReadyKey& jobs) const;
  // Returns the number of different machines of the workers that are around.
  int Machines() const;

 private:
  // A worker that asks for leases.
  struct Taker {
    const WorkerFacts& facts;
    std::array<bool, kMostKinds> takes{};      // By kind: it meets the kind's needs.
    std::array<int, kMostKinds> idle_slots{};  // The farm's, that this call has not filled yet.
    std::array<int, kMostKinds> slots{};
  };
  struct WorkerMemory {
    double seen_s = 0;
    std::string machine;              // Empty: not known.
    std::deque<Sha256Digest> groups;  // Groups that are warm there, the latest first.
  };
  // A worker as it said at its last call, until it is gone.
  struct Abilities {
    std::vector<std::string> kinds, tags;
    int64_t memory_mb = 0;
  };
  absl::StatusOr<Taker> TakerOf(const WorkerFacts& worker) const;
  absl::StatusOr<std::optional<JobRow>> Choose(const Taker& worker);
  absl::StatusOr<std::optional<JobRow>> ChooseOf(Study& study, KindId kind, const Taker& worker);
  absl::StatusOr<std::optional<JobRow>> ChooseWarm(const Taker& worker);
  bool FitsJob(const JobRow& job, const Taker& worker) const;  // Meets the job's own needs.
  bool OthersAround(const std::string& worker);
  StudyShare ShareOf(Study& study, const Taker& worker);
  absl::StatusOr<GrantedLease> Grant(JobRow job, const Taker& worker);
  // Splits `job` if slots would idle otherwise: it keeps the first of its rigs, and new jobs get
  // the rest.
  absl::Status SplitIfIdle(JobRow& job, const Taker& worker);
  // Returns whether only READY jobs of this kind are left to do for scenes.
  bool OnlyTheseLeft(KindId kind) const;
  uint64_t NextFence() { return (tables_.epoch << 32) | ++sequence_; }

  Tables& tables_;
  JobMoves& jobs_;
  Waiters& waiters_;
  std::map<std::string, WorkerMemory> workers_;
  std::map<std::string, Abilities> abilities_;
  double virtual_pass_ = 0;  // Pass of the study that was served last.
  uint32_t sequence_ = 0;
};

}  // namespace parallax
