// How much each setting of a search matters. Pure and thread-safe.
#pragma once

#include <vector>

#include "coordinator/search/trial_space.h"

namespace parallax {

// A trial's values and its objective.
struct Outcome {
  SearchValues values;
  double objective = 0;
};

// Returns for each field of the space the share of the objective's variance between trials that
// its mean at the field's value explains, the largest first: its main effect, Var(E[y | x]) /
// Var(y). The mean is a parabola over a range (in its logarithm, where the field is varied in it),
// and one value for each choice; trials where the field is not varied have a mean of their own,
// which is the effect of the fields that it depends on, and not its. The share is adjusted for the
// freedom of these means, so that settings without any effect have a share of 0 on average, not
// counting that it is at least 0. The interval has 95 % of replicates that draw trials with
// replacement; it begins at 0 unless the share exceeds that of 97.5 % of permutations of the
// objectives among trials where the field is varied. It is a function of the outcomes. With fewer
// trials than 3 more than the means are free, or equal objectives, the share is 0 with an interval
// of [0, 1]. Source: Saltelli et al., "Global sensitivity analysis: the primer", 2008, 1.2;
// Ezekiel, "Methods of correlation analysis", 1930 (adjustment); Efron and Tibshirani, "An
// introduction to the bootstrap", 1993, 13 (percentiles) and 15 (permutations).
std::vector<v1::SearchImportance> ImportancesOf(const SearchSpace& space,
                                                const std::vector<Outcome>& outcomes);

// Returns the outcomes of the first rung, which all trials of a search had, without the default.
std::vector<Outcome> OutcomesOf(const v1::SearchRecord& record);

}  // namespace parallax
