// How trainings went: the figures of each benchmark by step, from the scores of checkpoints.
#pragma once

#include <string>

#include "common/base/status.h"

namespace parallax::client {

// Reads `out_dir`/curves (scores of checkpoints before the last), scores/ and training/, and writes
// curves/learning_curves.csv (benchmark, metric, set, trainer, seed, step, value) and a picture of
// it for each benchmark, curves/<benchmark>.png: a line for each set, the mean over its seeds. Does
// nothing where no such scores are. Errors: those of reading and writing.
absl::Status WriteLearningCurves(const std::string& out_dir);

}  // namespace parallax::client
