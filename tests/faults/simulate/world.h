// What all parts of one run share.
#pragma once

#include <map>
#include <string>

#include "common/base/rng.h"
#include "common/base/version.h"
#include "tests/faults/simulate/knobs.h"
#include "tests/faults/simulate/schedule.h"

namespace parallax::faults {

// Guards that are switched off, to see whether the checks notice.
struct Mutation {
  UnsafeForTest queue;
  bool sizes_only = false;        // The check of the store believes files that have their size.
  bool no_acknowledging = false;  // A stream forgets what its consumers have acknowledged.
  bool no_outbox = false;         // A worker's process takes its unanswered reports with it.
  bool send_once = false;         // A worker sends a report once.
  bool remove_early = false;      // A report leaves the outbox when it is sent.
  bool any_worker = false;        // Workers of other releases get all kinds of jobs.
};

struct World {
  World(uint64_t run_seed, bool tells, const Mutation& off, bool without_end = false)
      : seed(run_seed),
        mutation(off),
        rng(SceneSeed{run_seed}, "simulate"),
        knobs(without_end ? WithoutEnd(DrawKnobs(rng.Child("knobs")))
                          : DrawKnobs(rng.Child("knobs"))),
        story(schedule, tells),
        dice(rng.Child("events")) {}

  // Returns the versions of the first release, or of the next.
  static StageVersions VersionsOf(int release);
  // Draws the time to an event that happens each `mean_s` seconds on average.
  double Next(double mean_s);
  // A message's delay: mostly short, seldom ten times the longest.
  double Delay() {
    return knobs.delay_s * dice.Uniform() * dice.Uniform() * (dice.Bernoulli(0.02) ? 10 : 1);
  }

  const uint64_t seed;
  const Mutation mutation;
  const Rng rng;
  const Knobs knobs;
  Schedule schedule;
  Story story;
  Rng dice;                // For everything that is drawn while the run goes on.
  bool has_faults = true;  // Until the faults stop.
  bool upgraded = false;   // The coordinator's machine has the next release.
};

// The way between one machine and the coordinator. Each direction may be closed for a while;
// messages of a stream then wait, calls are lost.
struct Line {
  double up_closed_until_s = 0;
  double down_closed_until_s = 0;
};

}  // namespace parallax::faults
