// A training run on disk. The same state gives the same bytes.
#pragma once

#include <string>

#include "common/base/status.h"
#include "worker/train/network.h"
#include "worker/train/optimiser.h"

namespace parallax {

// The randomness of a run is addressed by step, so `step` is also the position of all random
// streams.
struct Checkpoint {
  int64_t step = 0;                 // Steps that were done.
  nlohmann::ordered_json settings;  // ToJson of the settings, and "data_hashes".
  OptimiserState state;
};

// Replaces `path` in one step: whoever reads it sees the old or the new file, also after a crash.
// Errors: as WriteFile and rename(2).
absl::Status WriteCheckpoint(const std::string& path, const StereoNetwork& network,
                             const Checkpoint& checkpoint);

// Errors: kNotFound; kDataLoss when it is no checkpoint, was cut off, or is one of another network.
absl::StatusOr<Checkpoint> ReadCheckpoint(const std::string& path, const StereoNetwork& network);

}  // namespace parallax
