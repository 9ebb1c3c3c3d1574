#include "coordinator/queue/writer.h"

#include <pthread.h>
#include <sqlite3.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "common/base/seconds.h"

namespace parallax {
namespace {

constexpr int kReaderLooksAgainMs = 5000;

constexpr int64_t kScenesPerGroup = 256;     // Made in one transaction: some milliseconds.
constexpr int kCheckpointHardPages = 65536;  // Readers kept it from being reset: try harder.

std::chrono::duration<double> Seconds(double s) { return std::chrono::duration<double>(s); }

// The disk did not do what it was told; only a restart knows what is on it.
bool IsFatal(const absl::Status& status) {
  return status.code() == absl::StatusCode::kUnavailable ||
         status.code() == absl::StatusCode::kDataLoss;
}

}  // namespace

Writer::Writer(SqliteConnection& db, Machine& machine, const JobQueueOptions& options, Hooks hooks)
    : db_(db),
      machine_(machine),
      options_(options),
      hooks_(std::move(hooks)),
      fail_point_(options.fail_point) {
  if (fail_point_.armed()) db_.before_write = [this] { return fail_point_.Step(); };
  sqlite3_wal_hook(
      db_.raw(),
      [](void* self, sqlite3*, const char*, int pages) {
        static_cast<Writer*>(self)->wal_pages_ = pages;
        return SQLITE_OK;
      },
      this);
  stats_.jobs = machine_.tables().ledger.totals();
  if (options_.own_threads) thread_ = std::thread([this] { Loop(); });
}

Writer::~Writer() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
  sqlite3_wal_hook(db_.raw(), nullptr, nullptr);
  db_.before_write = nullptr;
}

void Writer::Enqueue(Command command) {
  {
    const std::lock_guard lock(mutex_);
    if (!stopping_) {
      queue_.push_back(std::move(command));
      // Under load the writer looks for itself.
      if (queue_.size() == 1) wake_.notify_one();
      return;
    }
  }
  if (command.done) command.done(Cancelled("the queue is closing"));
}

void Writer::AddStats(JobQueueStats& stats) const {
  const std::lock_guard lock(mutex_);
  for (size_t kind = 0; kind < options_.kinds->size(); ++kind) {
    for (size_t state = 0; state < kJobStates; ++state) {
      stats.jobs[{options_.kinds->at(kind).name(), kJobStateNames[state]}] =
          stats_.jobs[kind][state];
    }
  }
  stats.commits = stats_.commits;
  stats.commands = stats_.commands;
  stats.commit_seconds = stats_.commit_seconds;
  stats.commit_seconds_max = stats_.commit_seconds_max;
  stats.checkpoints = stats_.checkpoints;
  stats.checkpoint_seconds = stats_.checkpoint_seconds;
  stats.checkpoint_seconds_max = stats_.checkpoint_seconds_max;
  stats.largest_batch = stats_.largest_batch;
  stats.wal_pages = stats_.wal_pages;
  stats.commit_bounds_s = stats_.commit_s.bounds();
  stats.commit_counts = stats_.commit_s.Cumulative();
  stats.batch_bounds = stats_.batch.bounds();
  stats.batch_counts = stats_.batch.Cumulative();
}

std::vector<Writer::Command> Writer::NextGroup() {
  std::unique_lock lock(mutex_);
  const auto ready = [&] { return stopping_ || !queue_.empty(); };
  if (!expand_more_) {
    if (hooks_.tick_s > 0) {
      wake_.wait_for(lock, Seconds(hooks_.tick_s), ready);
    } else {
      wake_.wait(lock, ready);
    }
  }
  // Callers that the last group answered are about to ask again. Waiting for half of them pays
  // off.
  const size_t limit = static_cast<size_t>(std::max(1, options_.max_batch));
  if (last_group_ > 1 && !stopping_ && !queue_.empty()) {
    const auto until = std::chrono::steady_clock::now() + Seconds(options_.linger_s);
    while (queue_.size() < std::min(limit, last_group_ / 2) && !stopping_ &&
           std::chrono::steady_clock::now() < until) {
      wake_.wait_for(lock, std::chrono::microseconds(50));
    }
  }
  return TakeGroup(limit);
}

std::vector<Writer::Command> Writer::TakeGroup(size_t most) {
  const size_t n = std::min(most, queue_.size());
  std::vector<Command> group;
  group.reserve(n);
  std::move(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(n),
            std::back_inserter(group));
  queue_.erase(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(n));
  last_group_ = n;
  return group;
}

void Writer::Loop() {
  pthread_setname_np(pthread_self(), "queue-writer");  // For top and perf.
  last_tick_ = std::chrono::steady_clock::now();
  for (;;) {
    std::vector<Command> group = NextGroup();
    {
      const std::lock_guard lock(mutex_);
      if (stopping_ && group.empty() && queue_.empty()) return;
    }
    RunNext(std::move(group), std::chrono::steady_clock::now());
  }
}

bool Writer::Work() {
  std::vector<Command> group;
  {
    const std::lock_guard lock(mutex_);
    group = TakeGroup(static_cast<size_t>(std::max(1, options_.max_batch)));
  }
  return RunNext(std::move(group), options_.clock->Steady());
}

// Runs a group, with a tick if it is time for one. False if there was nothing to do.
bool Writer::RunNext(std::vector<Command> group, SteadyTime now) {
  if (hooks_.tick_s > 0 && now - last_tick_ >= Seconds(hooks_.tick_s)) {
    last_tick_ = now;
    if (hooks_.due()) group.push_back({"tick", hooks_.tick, nullptr});
  }
  if (group.empty() && !expand_more_) return false;
  RunGroup(group);
  return true;
}

void Writer::RunGroup(std::vector<Command>& group) {
  std::vector<absl::Status> results(group.size());
  savepoints_ = fail_point_.armed();  // A deliberate failure must not undo its group.
  absl::Status status = ApplyGroup(group, results);
  if (half_done_) {
    half_done_ = false;
    savepoints_ = true;
    Rollback(status);
    status = ApplyGroup(group, results);
  }
  if (!status.ok()) {
    Rollback(status);
    std::fill(results.begin(), results.end(), status);
  } else {
    hooks_.published(machine_.TakeEffects());
    const std::lock_guard lock(mutex_);
    ++stats_.commits;
    stats_.commands += group.size();
    stats_.batch.Add(static_cast<double>(group.size()));
    stats_.largest_batch = std::max(stats_.largest_batch, static_cast<int>(group.size()));
    stats_.wal_pages = wal_pages_;
    stats_.jobs = machine_.tables().ledger.totals();
  }
  for (size_t i = 0; i < group.size(); ++i) {
    if (group[i].done) group[i].done(results[i]);
  }
  CheckpointIfLong();
}

// A reader that finds the WAL's index half-written takes the write lock for a moment to look again;
// that is no reason to give up. Only here: a checkpoint must not wait for readers.
absl::Status Writer::Begin() {
  sqlite3_busy_timeout(db_.raw(), kReaderLooksAgainMs);
  const absl::Status status = db_.Run("BEGIN IMMEDIATE");
  sqlite3_busy_timeout(db_.raw(), 0);
  return status;
}

absl::Status Writer::ApplyGroup(std::vector<Command>& group, std::vector<absl::Status>& results) {
  RETURN_IF_ERROR(Begin());
  for (size_t i = 0; i < group.size(); ++i) {
    results[i] = ApplyOne(group[i].name, group[i].apply);
    if (half_done_) return results[i];
    // A full disk or a lost one takes the whole group with it.
    if (!db_.in_transaction() || IsFatal(results[i]) ||
        results[i].code() == absl::StatusCode::kResourceExhausted) {
      return results[i].ok() ? Internal("transaction lost") : results[i];
    }
  }
  RETURN_IF_ERROR(ApplyOne("expand", [this] {
    ASSIGN_OR_RETURN(expand_more_, machine_.expander().Expand(kScenesPerGroup));
    return absl::OkStatus();
  }));
  fail_point_.Begin("settle");
  RETURN_IF_ERROR(machine_.Settle());
  RETURN_IF_ERROR(machine_.tables().ledger.Flush());
  return Commit();
}

absl::Status Writer::ApplyOne(const char* name, const std::function<absl::Status()>& apply) {
  fail_point_.Begin(name);
  if (savepoints_) RETURN_IF_ERROR(db_.Run("SAVEPOINT command"));
  const int64_t written = db_.rows_written();
  machine_.BeginCommand();
  absl::Status status = apply();
  if (status.ok()) status = machine_.EndCommand();
  if (!status.ok()) machine_.UndoCommand();
  if (!savepoints_) {
    half_done_ =
        !status.ok() && db_.in_transaction() && db_.rows_written() != written && !IsFatal(status);
    return status;
  }
  if (!status.ok()) {
    if (!db_.in_transaction()) return status;
    RETURN_IF_ERROR(db_.Run("ROLLBACK TO command"));
  }
  RETURN_IF_ERROR(db_.Run("RELEASE command"));
  return status;
}

absl::Status Writer::Commit() {
  fail_point_.Begin("commit");
  if (const absl::Status status = fail_point_.Step(); !status.ok()) Fatal(status);
  const auto begin = std::chrono::steady_clock::now();
  const absl::Status status = db_.Run("COMMIT");
  const double seconds = SecondsSince(begin);
  if (!status.ok()) {
    if (status.code() == absl::StatusCode::kResourceExhausted) return status;
    Fatal(WithContext(status, "commit"));
  }
  if (const absl::Status after = fail_point_.Step(); !after.ok()) Fatal(after);
  const std::lock_guard lock(mutex_);
  stats_.commit_seconds += seconds;
  stats_.commit_s.Add(seconds);
  stats_.commit_seconds_max = std::max(stats_.commit_seconds_max, seconds);
  return absl::OkStatus();
}

void Writer::Rollback(const absl::Status& cause) {
  if (IsFatal(cause)) Fatal(cause);
  if (db_.in_transaction()) {
    if (const absl::Status status = db_.Run("ROLLBACK"); !status.ok()) Fatal(status);
  }
  // Reading everything again also brings back what an undone expansion had struck off.
  if (const absl::Status status = machine_.Reload(); !status.ok()) Fatal(status);
  expand_more_ = false;  // Not at once: the cause may still be there. The next group tries again.
}

void Writer::CheckpointIfLong() {
  if (wal_pages_ < checkpointed_at_) checkpointed_at_ = 0;  // It began anew.
  if (wal_pages_ - checkpointed_at_ < options_.checkpoint_pages) return;
  fail_point_.Begin("checkpoint");
  if (const absl::Status before = fail_point_.Step(); !before.ok()) Fatal(before);
  const auto begin = std::chrono::steady_clock::now();
  const int mode =
      wal_pages_ > kCheckpointHardPages ? SQLITE_CHECKPOINT_RESTART : SQLITE_CHECKPOINT_PASSIVE;
  const int code = sqlite3_wal_checkpoint_v2(db_.raw(), nullptr, mode, nullptr, nullptr);
  if ((code & 0xff) == SQLITE_IOERR || (code & 0xff) == SQLITE_CORRUPT) {
    Fatal(Unavailable("checkpoint: {}", sqlite3_errmsg(db_.raw())));
  }
  checkpointed_at_ = wal_pages_;
  if (const absl::Status after = fail_point_.Step(); !after.ok()) Fatal(after);
  const double seconds = SecondsSince(begin);
  const std::lock_guard lock(mutex_);
  ++stats_.checkpoints;
  stats_.checkpoint_seconds += seconds;
  stats_.checkpoint_seconds_max = std::max(stats_.checkpoint_seconds_max, seconds);
}

void Writer::Fatal(const absl::Status& status) {
  if (options_.on_fatal) options_.on_fatal(status);
  std::fprintf(stderr, "coordinator: the database can't be written: %s\n",
               std::string(status.message()).c_str());
  std::_Exit(70);
}

}  // namespace parallax
