// Samples the farm's status: at most twice a second however many callers ask, and regularly in the
// background, so that rates and the day's history are known when a user opens the page.
// Thread-safe.
#pragma once

#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/base/rate_estimator.h"
#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "coordinator/http/status_snapshot.h"
#include "coordinator/queue/reads/farm_history.h"

namespace parallax {

class StatusSampler {
 public:
  // All arguments must outlive the sampler. `space` may be null.
  StatusSampler(std::string store_uri, Clock& clock, JobQueue& queue,
                const CoordinatorServer& server, std::function<FarmSpace()> space = nullptr);
  ~StatusSampler();  // Calls Stop().

  // Reads the history that the database has kept, and starts sampling.
  void Start();
  void Stop();  // Idempotent.

  // Returns a snapshot that is at most half a second old. Errors: the queue's.
  absl::StatusOr<std::shared_ptr<const StatusSnapshot>> Take();
  std::vector<HistorySample> History() const;  // The oldest first.
  // Returns the seconds since the sampler was made.
  double Uptime() const;

 private:
  // Requires mu_.
  absl::StatusOr<StatusSnapshot> Read();
  absl::StatusOr<std::vector<v1::StudyStatus>> UnfinishedBefore(int64_t study);
  void CountPublished(const StatusSnapshot& fresh);
  void NoteEtas(StatusSnapshot& fresh);
  void NoteHistory(const StatusSnapshot& fresh);
  void RecallHistory();
  void Loop();

  const std::string store_uri_;
  Clock& clock_;
  JobQueue& queue_;
  const CoordinatorServer& server_;
  const std::function<FarmSpace()> space_;
  const SteadyTime started_;
  std::thread sampling_;

  std::mutex stop_mu_;
  std::condition_variable stop_;
  bool stopping_ = false;  // Guarded by stop_mu_.

  mutable std::mutex mu_;
  // Guarded by mu_.
  RateEstimator rate_;
  int64_t published_ = 0;                // Never falls, whichever studies come and go.
  std::map<int64_t, int64_t> pairs_of_;  // By study, as the last snapshot had them.
  int64_t newest_study_ = 0;
  std::map<int64_t, RateEstimator> study_rates_;  // Keys are ids of running studies.
  std::shared_ptr<const StatusSnapshot> snapshot_;
  SteadyTime snapshot_at_{};
  parallax::History history_;
};

}  // namespace parallax
