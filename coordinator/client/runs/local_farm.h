// A farm on this machine for as long as somebody needs it: a coordinator in this process, and
// workers as its children, which die with it.
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "coordinator/client/connection.h"
#include "coordinator/client/content/machine_check.h"
#include "coordinator/client/runs/embedded_coordinator.h"
#include "coordinator/client/runs/out_dir.h"
#include "coordinator/client/runs/worker_pool.h"

namespace parallax::client {

// Time that a worker has after SIGTERM for what it renders.
inline constexpr double kDrainGrace_s = 60;

// Workers of a coordinator in this process.
struct LocalWorkers {
  std::string coordinator;  // Its address.
  std::string store_dir;    // Folder of its database and store.
  std::string log_dir;
  int workers = 1;
  MachineOptions machine;
  Clock* clock = &Clock::System();
};

// Returns how such workers are started. Errors: kNotFound without the program `worker`.
absl::StatusOr<WorkerPoolOptions> PoolOf(const LocalWorkers& workers);

// Begins to log into a file of `log_dir` instead of to the screen.
void LogCoordinatorTo(const std::string& log_dir);

// Thread-safe. Has one thread, which keeps the workers.
class LocalFarm {
 public:
  // Starts a farm with database, store and logs in `dir`/.parallax. What failed there before is
  // tried again, and files that nothing needs any more are removed. Errors: those of OutDir, of the
  // coordinator and of PoolOf.
  static absl::StatusOr<std::unique_ptr<LocalFarm>> Start(const std::string& dir, int workers,
                                                          Clock* clock);
  ~LocalFarm();  // The workers hand back what they do, and end.
  LocalFarm(const LocalFarm&) = delete;
  LocalFarm& operator=(const LocalFarm&) = delete;

  const std::string& address() const { return coordinator_->address(); }  // "unix:/..."
  const std::string& dir() const { return dir_->path(); }
  // Returns OK while the farm works. Errors: kInternal for workers that can't start or keep
  // crashing; kResourceExhausted for a disk that is full.
  absl::Status status() const;

 private:
  explicit LocalFarm(std::unique_ptr<OutDir> dir) : dir_(std::move(dir)) {}
  absl::Status RetryFailed();
  void Loop();
  absl::Status Look(WorkerPool& pool);

  const std::unique_ptr<OutDir> dir_;
  std::unique_ptr<EmbeddedCoordinator> coordinator_;
  std::unique_ptr<Connection> connection_;
  WorkerPoolOptions pool_;
  // Used by the thread only.
  int64_t jobs_done_ = 0, results_ = 0;

  mutable std::mutex mu_;
  std::condition_variable stop_;
  // Guarded by mu_.
  bool stopping_ = false;
  absl::Status status_;
  std::thread thread_;
};

}  // namespace parallax::client
