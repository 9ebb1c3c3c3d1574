// Reads the files of all results in the store and compares their hashes with the database's, slowly
// and again and again. Damaged results are taken back, so that they are made again.
//
// A pass goes through the results in the order of their keys and keeps its place in the database: a
// restart goes on there. While the store is not there, nothing counts as damaged. A result that
// can't be read, twice, counts as damaged unless the next ones can't be read either.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "common/base/status.h"
#include "common/store/store.h"
#include "coordinator/queue/job_queue.h"

namespace parallax {

struct ScrubOptions {
  double bytes_per_s = 0;        // Bound on reading; 0: none.
  double every_s = 7 * 86400.0;  // Time from the begin of a pass to that of the next one.
  bool repair = true;            // Take damaged results back.
  Clock* clock = &Clock::System();
};

// Figures since the program started, and of the pass.
struct ScrubFigures {
  int64_t files = 0;
  int64_t bytes = 0;
  int64_t damaged = 0;  // Results.
  int64_t pairs_taken_back = 0;
  ScrubState pass;
};

// Thread-safe.
class Scrubber {
 public:
  // Both must outlive the scrubber.
  Scrubber(JobQueue& queue, const Store& store, const ScrubOptions& options)
      : queue_(queue), store_(store), options_(options) {}
  ~Scrubber();
  Scrubber(const Scrubber&) = delete;
  Scrubber& operator=(const Scrubber&) = delete;

  // Begins passes in a thread of its own.
  void Start();
  // Goes on with the pass under way, or begins one, to its end; `found` hears of each damaged
  // result. Returns the state of the pass. Errors: those of the queue; kUnavailable while the store
  // is not there or several results in a row can't be read; kCancelled when the scrubber is being
  // destroyed.
  absl::StatusOr<ScrubState> Pass(const std::function<void(const DamagedResult&)>& found);
  ScrubFigures figures() const;

 private:
  void Loop();
  bool WaitFor(double seconds);  // Returns false when it is time to end.
  // `unreadable` counts the results up to now that could not be read, in a row.
  absl::StatusOr<std::vector<DamagedResult>> DamagedOf(const std::vector<StoredOutput>& outputs,
                                                       int& unreadable);
  absl::StatusOr<std::string> WhyDamaged(const StoredOutput& output);
  absl::StatusOr<std::string> WhyDamagedFile(const JobKind::OutputFile& file);
  absl::Status TakeBack(const std::vector<DamagedResult>& damaged);

  JobQueue& queue_;
  const Store& store_;
  const ScrubOptions options_;
  mutable std::mutex mu_;
  std::condition_variable stop_;
  // Guarded by mu_.
  ScrubFigures figures_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace parallax
