// Evidence for and against jobs that lose their workers: how long workers held each of them, and
// how many workers were lost with it and without it meanwhile. policy.h judges it.
//
// Kept in memory only: deaths of the coordinator are nobody's fault, so each start counts anew, and
// what is not known here is held against no job. Used by the writing thread only.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <unordered_map>

#include "coordinator/queue/commands/policy.h"
#include "coordinator/queue/lease.h"

namespace parallax {

// Times are steady seconds, which never go back from call to call.
class LossEvidence {
 public:
  // Notes that time has passed with this number of living workers.
  void Pass(double now, size_t workers);
  // Notes that workers were lost.
  void CountLost(uint64_t workers) { lost_ += workers; }
  // Note the begin and the end of a lease. `progress` is what the attempt had reached, in any
  // measure that grows; `machine` is its worker's.
  void Begin(int64_t job, uint64_t fence);
  void End(int64_t job, uint64_t fence, LeaseEnd end, const std::string& machine, double progress);
  // Takes a loss back, because the worker was only away.
  void TakeBack(int64_t job, uint64_t fence);

  // Returns the record of a leased job whose worker is lost now, that loss included, with all
  // machines but machines_all and with_another. `lost_now` workers were lost since the last call of
  // CountLost, this one included. An attempt that came further than all before clears its job.
  LossHistory HistoryOf(int64_t job, uint64_t fence, uint64_t lost_now, const std::string& machine,
                        double progress) const;

 private:
  struct Record {  // One for each job that has lost a worker; all counts from the first loss.
    std::map<uint64_t, std::string> losses;  // Machines, by fence; the first loss included.
    uint64_t lost_before = 0;                // Workers that all jobs had lost by then.
    double worker_s_before = 0;              // Living workers' time until then.
    double held_s = 0;
    double progress = 0;
  };
  double HeldFor(int64_t job, uint64_t fence) const;

  double now_ = 0;
  double worker_s_ = 0;  // Time of all workers together.
  uint64_t lost_ = 0;
  struct Lease {
    uint64_t fence = 0;
    double since = 0;
  };
  std::unordered_map<int64_t, Lease> leases_;
  std::map<int64_t, Record> records_;
};

}  // namespace parallax
