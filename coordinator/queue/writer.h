// The one thread that writes the database. It takes commands in groups: BEGIN IMMEDIATE, the
// commands, the scenes that variants now need, the counters, one COMMIT; only then are callers
// answered. So durability costs one fsync for each group, whatever the number of callers.
//
// A command is done whole or not at all. With a SAVEPOINT around each command, SQLite would copy
// every page that each of them touches, although commands hardly ever fail once they have begun to
// write. So a group is first tried without SAVEPOINTs. If a command fails after it has written
// something, the whole group is rolled back and run again, each command in a SAVEPOINT of its own.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <semaphore>
#include <thread>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/commands/machine.h"
#include "coordinator/queue/database/fail_point.h"
#include "coordinator/queue/tables/latency_histogram.h"

namespace parallax {

// Returns the status of a command's result. Errors: the command's.
inline absl::Status StatusOf(const absl::Status& status) { return status; }
template <typename T>
absl::Status StatusOf(const absl::StatusOr<T>& result) {
  return result.status();
}

// Figures of the writer since the program started; seconds are wall-clock seconds.
struct WriterStats {
  uint64_t commits = 0;
  uint64_t commands = 0;
  double commit_seconds = 0;
  double commit_seconds_max = 0;
  uint64_t checkpoints = 0;
  double checkpoint_seconds = 0;
  double checkpoint_seconds_max = 0;
  int largest_batch = 0;
  int64_t wal_pages = 0;
  JobCounts jobs{};
  CountHistogram commit_s{
      {0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5}};
  CountHistogram batch{{1, 2, 4, 8, 16, 32, 64, 128, 256, 512}};
};

class Writer {
 public:
  struct Command {
    const char* name;                               // For fail points and messages.
    std::function<absl::Status()> apply;            // Changes the database; an error undoes it.
    std::function<void(const absl::Status&)> done;  // Called after the commit.
  };
  // Functions that the writer's thread calls. `published` gets the effects of a group after its
  // commit, before any `done` of the group. `due` says whether the command `tick` should run now;
  // it is asked at least once every tick_s seconds.
  struct Hooks {
    std::function<void(const Effects&)> published;
    std::function<bool()> due;
    std::function<absl::Status()> tick;
    double tick_s = 0;  // 0: never.
  };
  Writer(SqliteConnection& db, Machine& machine, const JobQueueOptions& options, Hooks hooks);
  ~Writer();  // Finishes all accepted commands.

  // Accepts a command. Thread-safe. After the destructor has begun, `done` gets kCancelled.
  void Enqueue(Command command);
  // Runs a command and waits for its commit. Returns what `apply` does, a Status or StatusOr.
  // Thread-safe. Errors: those of `apply`; the commit's.
  template <typename Apply>
  auto Do(const char* name, const Apply& apply) -> decltype(apply());
  // Without a thread of its own: runs the next group, on the caller's. Returns false if there is
  // none.
  bool Work();
  // Sets the figures of the writer and the numbers of jobs. Thread-safe.
  void AddStats(JobQueueStats& stats) const;

 private:
  void Loop();
  std::vector<Command> NextGroup();  // Empty if it is time for a tick, more scenes or the end.
  std::vector<Command> TakeGroup(size_t most);  // Requires mutex_.
  bool RunNext(std::vector<Command> group, SteadyTime now);
  void RunGroup(std::vector<Command>& group);
  absl::Status Begin();
  absl::Status ApplyGroup(std::vector<Command>& group, std::vector<absl::Status>& results);
  absl::Status ApplyOne(const char* name, const std::function<absl::Status()>& apply);
  absl::Status Commit();
  void Rollback(const absl::Status& cause);
  void CheckpointIfLong();
  [[noreturn]] void Fatal(const absl::Status& status);

  SqliteConnection& db_;
  Machine& machine_;
  const JobQueueOptions& options_;
  const Hooks hooks_;
  FailPoint fail_point_;
  bool savepoints_ = false;  // The current group's commands have SAVEPOINTs.
  bool half_done_ = false;   // A command without SAVEPOINT failed after it had written.
  bool expand_more_ = true;
  size_t last_group_ = 0;
  SteadyTime last_tick_{};
  int wal_pages_ = 0;
  int checkpointed_at_ = 0;

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Command> queue_;  // Guarded by mutex_, like all below.
  bool stopping_ = false;
  WriterStats stats_;

  std::thread thread_;
};

template <typename Apply>
auto Writer::Do(const char* name, const Apply& apply) -> decltype(apply()) {
  decltype(apply()) result = Unknown("not run");
  std::binary_semaphore answered(0);
  Enqueue({name, [&] { return StatusOf(result = apply()); },
           [&](const absl::Status& status) {
             if (!status.ok()) result = status;
             answered.release();
           }});
  while (!options_.own_threads && !answered.try_acquire()) Work();
  if (options_.own_threads) answered.acquire();
  return result;
}

}  // namespace parallax
