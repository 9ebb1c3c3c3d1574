// Learning curves of trainings: the figures of each benchmark by step, from the scores of
// checkpoints.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "worker/evaluate/scores.h"

namespace parallax::client {

// Finds the steps of `evaluations`, those of checkpoints before the last among them, in
// `out_dir`/training. Writes curves/learning_curves.csv (benchmark, metric, set, trainer, seed,
// step, value) and, for each benchmark, the picture curves/<benchmark>.png with a line for each
// set, the mean over its seeds. Does nothing if there are no such scores. Errors: those of writing.
absl::Status WriteLearningCurves(const std::string& out_dir,
                                 const std::vector<Evaluation>& evaluations);

}  // namespace parallax::client
