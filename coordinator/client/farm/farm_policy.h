// Decides how many pilots (workers that a batch system starts) a farm should have. Pure functions
// of a view of the farm at one moment.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "parallax/v1/service.pb.h"

namespace parallax::client {

// One pilot: a task of an array in the batch system's queue.
struct Pilot {
  enum class State { kPending, kRunning, kEnding };
  std::string id;  // Id by which the batch system cancels it: "17_3".
  State state = State::kPending;
};

// Jobs that need slots.
struct Demand {
  int64_t waiting = 0;  // Jobs that may start now or after their back-off.
  int64_t leased = 0;   // Jobs that workers have.
};

// Bounds on the number of pilots, and the slots of each.
struct FarmLimits {
  int min = 0;
  int max = 1;
  int slots_per_pilot = 1;
};

// The farm as it was seen at one moment.
struct FarmView {
  Demand demand;
  int64_t other_slots = 0;  // Slots of connected workers that are no pilots.
  std::vector<Pilot> pilots;
};

// The pilots that are wanted, and the changes that lead there.
struct FarmDecision {
  int wanted = 0;   // Pilots in all, within the limits.
  int pending = 0;  // Pilots that wait now.
  int running = 0;
  int submit = 0;                   // New ones.
  std::vector<std::string> cancel;  // Pilots that still wait, the newest first.
};

// Jobs of running studies that wait for a slot or have one. Jobs that wait for other jobs, or
// that limits hold back, are no demand, and paused studies have none.
Demand DemandOf(const std::vector<v1::StudyStatus>& studies);

// Counts the slots of connected workers whose names do not begin with `pilot_prefix`. Draining
// workers take no work and do not count.
int64_t OtherSlots(const std::vector<v1::WorkerStatus>& workers, const std::string& pilot_prefix);

// Decides how many pilots to submit and which to cancel. Pilots that are ending do not count, so
// their work brings new ones. Running pilots are never cancelled: without work they end by
// themselves. Requires that `view.pilots` is in the order of submission.
FarmDecision Decide(const FarmView& view, const FarmLimits& limits);

// Returns the seconds to wait before the next submission, after `fruitless` submissions in a row
// that brought no worker: `interval_s`, doubled each time from the second on, but at most ten
// minutes (or `interval_s` if that is longer).
double SubmissionPause(double interval_s, int fruitless);

}  // namespace parallax::client
