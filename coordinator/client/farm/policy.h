// How many pilots (workers that a batch system starts) a farm should have: decisions as pure
// functions over what was seen at one moment.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "parallax/v1/service.pb.h"

namespace parallax::client {

// One task of an array in the batch system's queue.
struct Pilot {
  enum class State { kPending, kRunning, kEnding };
  std::string id;  // As the batch system wants it for a cancellation: "17_3".
  State state = State::kPending;
};

// Work that needs slots.
struct Demand {
  int64_t waiting = 0;  // Jobs that may start now or after their back-off.
  int64_t leased = 0;   // Jobs that workers have.
};

struct FarmLimits {
  int min = 0;
  int max = 1;
  int slots_per_pilot = 1;
};

struct FarmView {
  Demand demand;
  int64_t other_slots = 0;  // Slots of connected workers that are no pilots.
  std::vector<Pilot> pilots;
};

struct FarmDecision {
  int wanted = 0;   // Pilots in all, within the limits.
  int pending = 0;  // Pilots of now.
  int running = 0;
  int submit = 0;                   // New ones.
  std::vector<std::string> cancel;  // Pilots that still wait, the newest first.
};

// Jobs of running studies that wait for a slot or have one. Jobs that wait for other jobs, or
// that limits hold back, are no demand, and paused studies have none.
Demand DemandOf(const std::vector<v1::StudyStatus>& studies);

// Slots of connected workers whose names do not begin with `pilot_prefix`; those that drain take no
// work.
int64_t OtherSlots(const std::vector<v1::WorkerStatus>& workers, const std::string& pilot_prefix);

// Pilots that end or were killed do not count, so their work brings new ones. Running pilots are
// never cancelled: those without work end by themselves. `view.pilots` is in order of submission.
FarmDecision Decide(const FarmView& view, const FarmLimits& limits);

// Seconds until pilots are submitted again after `fruitless` submissions in a row of which no
// worker came: `interval_s`, doubled each time from the second on, at most ten minutes (or
// `interval_s`, where that is longer).
double SubmissionPause(double interval_s, int fruitless);

}  // namespace parallax::client
