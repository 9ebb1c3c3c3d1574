// Everything that a seed decides before its run begins. Times are seconds of virtual time.
#pragma once

#include "common/base/rng.h"
#include "coordinator/queue/job_queue.h"
#include "worker/agent/agent.h"

namespace parallax::faults {

// What happens to the database's files while the coordinator is down.
enum class Lie {
  kNone,
  kFlippedBit,  // A bit of the database is another one.
  kOlder,       // A backup is put back, a day later.
  kAnother,     // Another farm's database is put in its place.
  kNoLog,       // Its log (WAL) is deleted.
  kNoStore,     // The folder of the store is gone.
};

struct Knobs {
  double scale = 1;       // All time-outs are multiplied by it; a quarter of the runs has 0.01.
  double faults_s = 600;  // How long there are faults and orders.

  // The coordinator.
  JobQueueOptions queue;  // Without paths and clock.
  int user_running = 0;   // The users' limit in it; 0: none.
  double reconnect_grace_s = 30;
  double turn_s = 0.01;  // The longest wait of its threads for their turns.
  double coordinator_life_s = 300;
  double power_cut_p = 0.5;  // Of its deaths.
  bool disk_errs = false;    // Its disk has errors, or is full, now and then.
  Lie lie = Lie::kNone;
  int lie_at = 2;  // Before this start of it, or a later one.
  // When it is killed more often than a lease lasts, for many leases, and one worker with it; 0:
  // never.
  double crash_loop_at_s = 0;
  // From when on its machine gets the next release, whose pictures are others, as soon as a report
  // is on its way; 0: never. Workers get it one by one, some before.
  double upgrade_at_s = 0;

  // The network.
  double delay_s = 0.05;  // The longest delay of most messages.
  double loss_p = 0.02;   // Of calls' requests, and of their replies.
  double repeat_p = 0.02;
  double cut_every_s = 200;    // Between partitions of one machine.
  double cut_s = 20;           // Their mean length.
  double break_every_s = 300;  // Between ends of one machine's stream.

  // The machines.
  int workers = 3;
  int slots = 2;
  double drift = 1e-4;  // Clocks' rates differ by at most so much.
  double worker_life_s = 400;
  double worker_away_s = 20;
  double leave_every_s = 500;  // Between orders to drain of one worker.
  AgentOptions agent;

  // The work.
  int studies = 2;
  int pairs = 6;
  double trainings_p = 0.3;
  double job_s = 20;
  double fail_p = 0.05;
  double reject_p = 0.05;  // Of solves.
  double kill_p = 0.01;    // The job takes its worker with it.
  double order_every_s = 60;
  bool has_files = false;         // Results have files in a store, which is read again.
  double store_lie_every_s = 60;  // Between changes of such a file behind everybody's back.
  bool has_stream = false;        // A training takes the pairs of a stream.
  bool has_search = false;
  // Studies are forgotten when they have ended, and others are submitted in their place.
  bool replaces_studies = false;
};

Knobs DrawKnobs(Rng rng);
// The same farm, but its coordinator lives on, and has always as many studies.
Knobs WithoutEnd(Knobs knobs);

}  // namespace parallax::faults
