// Runs a trainer's program for one job: prepares its folder, follows its progress, stores its
// checkpoints, and judges its end.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "worker/agent/attempts/job_handler.h"
#include "worker/jobs/training/checkpoint_keeper.h"
#include "worker/train/contract/installed_trainers.h"

namespace parallax {

// Everything that a trainer must know about one training.
struct TrainingPlan {
  InstalledTrainer trainer;
  uint64_t seed = 0;
  std::string start;  // A checkpoint whose weights it begins with; empty: drawn by the seed.
  int64_t steps = 0;  // > 0.
  int threads = 1;
  int width_px = 0, height_px = 0, batch = 0;             // 0: the trainer's own.
  int checkpoints = 1;                                    // For learning curves, the last included.
  std::vector<std::pair<std::string, std::string>> data;  // Folder and weight of each part.
  std::string work_dir;                                   // An existing folder: out/, log.txt.
  Clock* clock = &Clock::System();
};

// A checkpoint of an earlier attempt, copied to this machine.
struct ResumePoint {
  CheckpointFacts facts;
  std::string path;
  std::string curve;  // Text of its curve.csv.
};

// The outcome of a training.
struct TrainedNetwork {
  std::string final_path;  // The trained network.
  // By step, without the last: those for learning curves.
  std::vector<std::pair<int64_t, std::string>> checkpoints;
  std::string log_path;
  std::string curve;  // CSV: step, loss, epe_px, train_s.
  std::vector<std::string> command;
  double loss = 0;     // Smoothed, at the end; 0 if the trainer told none.
  double train_s = 0;  // Over all attempts.
  double cpu_s = 0;    // CPU time of this attempt.
};

// Returns the number of training steps between checkpoints: at most 250, and if possible a divisor
// of the distance between the checkpoints for learning curves.
int64_t CheckpointEvery(int64_t steps, int checkpoints);

// Runs the trainer to its end. `keeper` gets each new checkpoint. `progress` is told the figures
// "step", "steps", "loss", "epe_px" and "eta_s", as far as they are known, whenever the trainer
// tells something.
//
// Errors: each with the log's tail (see WithLogTail): kFailedPrecondition when a loss is not finite
// or the trainer's arguments are refused; kResourceExhausted when memory is exhausted; kAborted
// when a signal ended it; kInternal for another exit status or a missing network; kCancelled;
// kUnimplemented when the trainer knows no size or batch. Also those of ChildProcess::Start and
// CheckpointKeeper::Put.
absl::StatusOr<TrainedNetwork> RunTrainer(const TrainingPlan& plan,
                                          const std::optional<ResumePoint>& resume,
                                          CheckpointKeeper& keeper, const CancelToken& cancel,
                                          const JobProgressFn& progress);

}  // namespace parallax
