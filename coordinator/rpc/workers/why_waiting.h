// Says why READY jobs do not run: a decision over a snapshot of the connected workers. Everything
// else (status, watch, jobs, the page, metrics, the note at submit) only shows what is decided
// here.
//
// Pure functions; thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "coordinator/queue/ready_key.h"

namespace parallax {

// Connected workers with equal abilities, and how many of them are in which state.
struct WorkerGroup {
  std::vector<std::string> kinds;  // Kinds of jobs that they take.
  std::vector<std::string> tags;
  int64_t memory_mb = 0;
  int64_t free = 0;  // With at least one slot without a job.
  int64_t busy = 0;
  int64_t drained = 0;    // Drained or draining: no new jobs.
  int64_t suspended = 0;  // Failed all their jobs of late; see ConductBook.

  int64_t workers() const { return free + busy + drained + suspended; }
};

// The reasons that hold back a study as a whole.
struct StudyHold {
  bool paused = false;
  std::string at_limit;  // "max_running 8"; empty: no limit does.
};

// A reason. `code` is one of kWaitCodes.
struct WaitReason {
  std::string code;
  std::string text;  // For people, without the jobs: "no connected worker has the tag big".
  bool operator==(const WaitReason&) const = default;
};

// The codes, in the order in which they are looked for. Up to "memory", no worker that is connected
// could ever run the jobs; "busy" and "starting" need nothing but time.
inline constexpr const char* kWaitCodes[] = {
    "pause",  "no_worker", "kind",      "trainer", "benchmark", "gpu",     "tag",
    "memory", "drain",     "suspended", "limit",   "busy",      "starting"};

// Returns whether the code says that no connected worker could ever run the jobs.
bool IsUnservable(const std::string& code);

// Returns whether the code says that workers are connected, and a person must give one of them what
// the jobs need.
bool NeedsPerson(const std::string& code);

// Returns why jobs of this kind and with these needs do not run.
WaitReason WhyWaiting(const ReadyKey& jobs, const StudyHold& study,
                      std::span<const WorkerGroup> workers);

}  // namespace parallax
