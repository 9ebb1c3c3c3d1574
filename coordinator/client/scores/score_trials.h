// The objective of a search's trials, from the scores of a rung's study.
#pragma once

#include <vector>

#include "common/base/status.h"
#include "coordinator/search/trial_scores.h"
#include "worker/evaluate/scores.h"

namespace parallax {

// Returns the scores of the trained variants of these evaluations, by name. The error is bad-2 in
// the region of a benchmark's headline, in %: the mean over images, each benchmark counting alike.
// Differences are paired by images and seeds, over all benchmarks at once; intervals draw images of
// all benchmarks together, so they are rather too wide where benchmarks differ. Pure. Errors:
// kFailedPrecondition if a variant lacks scores, or has others than the default; kInvalidArgument
// without a variant named "default".
absl::StatusOr<std::vector<TrialScore>> TrialScoresOf(const std::vector<Evaluation>& evaluations,
                                                      const ScoreQuery& query);

// Returns TrialScoresOf the score files of a study that are in `store` now. Thread-safe. Errors:
// those of TrialScoresOf and StudyScores.
absl::StatusOr<std::vector<TrialScore>> ScoreTrials(JobQueue& queue, const Store& store,
                                                    const ScoreQuery& query);

}  // namespace parallax
