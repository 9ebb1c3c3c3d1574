// The training run: reads batches, writes checkpoints, reports progress. This header does not
// include torch.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "worker/train/data/training_data.h"
#include "worker/train/network/settings.h"

namespace parallax {

// Peak of the learning rate, unless told, of runs that begin with trained weights.
inline constexpr double kStartedLearningRate = 0.3e-3;

// A run: its settings, its data and its files.
struct TrainingJob {
  TrainSettings settings;
  // If above 0, a few steps are timed first, and `settings.steps` becomes the number that fits into
  // this time.
  double minutes = 0;
  std::vector<TrainingSource> sources;
  std::vector<TrainingSource> heldout;  // Scored at the end; may be empty.
  int heldout_pairs = 50;
  std::string out_dir;
  std::string start;   // A checkpoint of any run whose weights this one begins with, or empty.
  std::string resume;  // A checkpoint of the same run, or empty.
  int64_t checkpoint_every = 250;  // Steps.
  double checkpoint_s = 1e9;       // Also when the last one is older.
  int progress_every = 10;         // Steps.
  int loader_threads = 1;
};

// How a run ended.
struct TrainingEnd {
  TrainerExit exit = TrainerExit::kDone;
  std::string message;  // One line; empty when done.
};

// Runs the training. Writes `out_dir`/train.json, checkpoint-<step>.pt (step in six digits) and
// final.pt, and calls `progress` with one JSON object for each event. A run that is killed and
// resumed from any of its checkpoints ends in a final.pt of the same bytes as one that is left
// alone (same machine type and threads). When `stop` becomes true, it writes a checkpoint and ends
// with TrainerExit::kStopped.
TrainingEnd RunTraining(const TrainingJob& job, const std::atomic<bool>& stop,
                        const std::function<void(const nlohmann::ordered_json&)>& progress);

}  // namespace parallax
