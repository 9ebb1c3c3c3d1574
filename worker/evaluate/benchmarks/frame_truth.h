#pragma once

#include <string>

#include "worker/evaluate/benchmark.h"

namespace parallax {

// Reads the left view's truth of a frame of our own datasets, in `dir`. Sky and the exterior of
// rooms have no truth. Errors: those of ReadFrame; kDataLoss for masks of another size.
absl::StatusOr<PairTruth> ReadFrameTruth(const std::string& dir);

}  // namespace parallax
