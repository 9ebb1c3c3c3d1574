// The workers of `run`: starts them as child processes, keeps them alive and drains them.
//
// A child that dies is started again after a growing pause, and its jobs go to new attempts.
// Crashes in a row without any result in between are a loop, which is an error. Children die with
// this process, whatever kills it.
//
// Not thread-safe. All calls must come from one thread, because Linux ties a child's life to the
// thread that started it.
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/base/system/clock.h"

namespace parallax::client {

struct WorkerPoolOptions {
  std::string binary;
  // Returns the arguments of worker `index`, from 0.
  std::function<std::vector<std::string>(int index)> arguments;
  int workers = 1;
  std::string log_dir;  // <log_dir>/worker-<index>.log; made if absent.
  // Number of crashes in a row, without a result in between, at which Poll returns an error. The
  // coordinator blames a job for its workers' deaths only while other work gets done.
  int most_crashes = 8;
  Clock* clock = &Clock::System();
};

class WorkerPool {
 public:
  explicit WorkerPool(WorkerPoolOptions options);
  ~WorkerPool();  // Kills what still runs.
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  // Starts all workers. Errors: those of making the log folder; kNotFound without a worker program.
  absl::Status Start();
  // Restarts children that have died; call it about twice a second. `results` is any count that
  // grows with the work done; its growth ends a row of crashes. Errors: kInternal for a crash loop
  // or a worker that refuses its arguments, with the end of its log in the message.
  absl::Status Poll(int64_t results);
  // Ends all workers. The first SIGTERM lets them finish their jobs. A second one, after `grace_s`
  // seconds or as soon as `hurry()` is true, makes them hand their jobs back. Workers that are
  // still there some seconds later are killed.
  void Drain(double grace_s, const std::function<bool()>& hurry);

  int running() const;
  int crashes() const { return crashes_; }  // All crashes so far.
  std::vector<pid_t> pids() const;
  // Returns the CPU time (user + system) of all children that have ended so far.
  double cpu_seconds() const { return cpu_seconds_; }
  // Returns the last lines of the log of the worker that crashed last, or of the first worker.
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

}  // namespace parallax::client
