// Worker children of `run`: started, kept alive, drained.
//
// A child that dies is started again after a growing pause; what it held goes to another attempt.
// Crash after crash without any result in between is a loop, and an error. Children die with this
// process, whatever kills it.
//
// Not thread-safe, and all calls come from one thread: Linux ties a child's life to the thread that
// started it.
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "common/base/status.h"

namespace parallax::client {

struct WorkerPoolOptions {
  std::string binary;
  // Arguments of worker `index`, from 0.
  std::function<std::vector<std::string>(int index)> arguments;
  int workers = 1;
  std::string log_dir;  // <log_dir>/worker-<index>.log; made if absent.
  // Crashes in a row, without a result in between, that end the pool. A job that kills its workers
  // is put aside by the coordinator after three, so a larger number means that it isn't the job.
  int most_crashes = 8;
  Clock* clock = &Clock::System();
};

class WorkerPool {
 public:
  explicit WorkerPool(WorkerPoolOptions options);
  ~WorkerPool();  // Kills what still runs.
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  // Errors: the log folder's; kNotFound without a worker program.
  absl::Status Start();
  // Looks after the children; call it about twice a second. `results`: any count that grows with
  // the work done; its growth ends a row of crashes. Errors: kInternal for a crash loop or a worker
  // that refuses its arguments, with the end of its log in the message.
  absl::Status Poll(int64_t results);
  // SIGTERM: workers finish what they hold. After `grace_s`, or as soon as `hurry()`, a second one:
  // they hand it back; whoever is still there some seconds later is killed.
  void Drain(double grace_s, const std::function<bool()>& hurry);

  int running() const;
  int crashes() const { return crashes_; }  // In all.
  std::vector<pid_t> pids() const;
  // Of all children that have ended so far, user + system.
  double cpu_seconds() const { return cpu_seconds_; }
  // The last lines of the log of the worker that crashed last, or of the first one.
  std::vector<std::string> LogTail(size_t lines) const;

 private:
  struct Child {
    pid_t pid = 0;          // 0: not running.
    double start_at_s = 0;  // When not running: next start.
    int crashes_in_row = 0;
  };
  double Now() const;
  absl::Status Spawn(int index);
  absl::Status OnExit(int index, int wait_status);
  void SignalAll(int signal);
  void ReapEnded();
  std::string LogPath(int index) const;

  const WorkerPoolOptions options_;
  std::vector<Child> children_;
  int64_t results_ = 0;
  int crashes_ = 0;
  int crashes_in_row_ = 0;
  int crashed_last_ = 0;
  double cpu_seconds_ = 0;
};

// The program `worker` beside this one. $PARALLAX_WORKER names another. Errors: kNotFound, saying
// where it was sought.
absl::StatusOr<std::string> FindWorkerBinary();

}  // namespace parallax::client
