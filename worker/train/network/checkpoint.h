// Checkpoints of training runs. The same state gives the same bytes.
#pragma once

#include <string>

#include "common/base/status.h"
#include "worker/train/network/network.h"
#include "worker/train/network/optimiser.h"

namespace parallax {

// State of a run. Its random streams are addressed by step, so `step` is their position too.
struct Checkpoint {
  int64_t step = 0;                 // Number of steps done.
  nlohmann::ordered_json settings;  // ToJson of the settings, and "data_hashes".
  OptimiserState state;
};

// Replaces `path` atomically: readers see the old or the new file, even after a crash.
// Errors: as WriteFile and rename(2).
absl::Status WriteCheckpoint(const std::string& path, const StereoNetwork& network,
                             const Checkpoint& checkpoint);

// Errors: kNotFound; kDataLoss for a file that is truncated, no checkpoint, or another network's.
absl::StatusOr<Checkpoint> ReadCheckpoint(const std::string& path, const StereoNetwork& network);

}  // namespace parallax
