// Learning curves of trainings: the figures of each benchmark by step, from the scores of
// checkpoints.
#pragma once

#include <string>

#include "common/base/status.h"

namespace parallax::client {

// Reads `out_dir`/curves (scores of checkpoints before the last), scores/ and training/. Writes
// curves/learning_curves.csv (benchmark, metric, set, trainer, seed, step, value) and, for each
// benchmark, the picture curves/<benchmark>.png with a line for each set, the mean over its seeds.
// Does nothing if there are no such scores. Errors: those of reading and writing.
absl::Status WriteLearningCurves(const std::string& out_dir);

}  // namespace parallax::client
