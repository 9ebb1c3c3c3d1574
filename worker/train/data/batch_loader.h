// Prepares batches ahead of time. A batch is a pure function of (sources, settings, step): threads
// affect only when it is ready, never its content.
#pragma once

#include <memory>
#include <vector>

#include "worker/train/data/augment.h"

namespace parallax {

// The crops of one training step.
struct TrainingBatch {
  std::vector<TrainingCrop> crops;
  std::vector<std::string> names;  // Names of the frames, one a crop.
};

// Loads batches for one consumer thread. The destructor waits for batches in preparation.
class BatchLoader {
 public:
  // `sources` must outlive the loader. The first batch is that of `first_step`; `threads` threads
  // prepare up to `ahead` batches ahead.
  BatchLoader(const std::vector<TrainingSource>& sources, const TrainSettings& settings,
              int64_t first_step, int threads = 1, int ahead = 4);
  ~BatchLoader();
  BatchLoader(const BatchLoader&) = delete;
  BatchLoader& operator=(const BatchLoader&) = delete;

  // Waits for the next step's batch and returns it. Errors: those of ReadTrainingPair and Augment,
  // naming the frame; kResourceExhausted when memory was short; kInternal for another exception.
  absl::StatusOr<TrainingBatch> Next();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace parallax
