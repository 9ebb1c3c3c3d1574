// Prepares batches ahead of time. A batch is a pure function of (sources, settings, step): threads
// affect only when it is ready, never its content.
#pragma once

#include <memory>
#include <vector>

#include "worker/train/augment.h"

namespace parallax {

// The crops of one training step.
struct TrainingBatch {
  std::vector<TrainingCrop> crops;
  std::vector<std::string> names;  // Names of the frames, one a crop.
};

// For one consumer. The destructor waits for batches in preparation.
class BatchLoader {
 public:
  // `sources` must outlive the loader. Batches start with that of `first_step`; `threads` threads
  // prepare up to `ahead` of them.
  BatchLoader(const std::vector<TrainingSource>& sources, const TrainSettings& settings,
              int64_t first_step, int threads = 1, int ahead = 4);
  ~BatchLoader();
  BatchLoader(const BatchLoader&) = delete;
  BatchLoader& operator=(const BatchLoader&) = delete;

  // The next step's batch; waits for it. Errors: as ReadTrainingPair and Augment, naming the frame.
  absl::StatusOr<TrainingBatch> Next();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace parallax
