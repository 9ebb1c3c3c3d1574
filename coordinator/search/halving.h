// The decisions of a search, as pure functions of its record: which trials go on, when it is over,
// which trial is the best. Thread-safe.
//
// Successive halving: a rung's trials are compared on the same pictures and seeds, and at most one
// of `keep_one_of` goes on. First those are left behind that are significantly worse than the
// default or than the best; then the worst of the others. The default always goes on.
// Source: Jamieson and Talwalkar, "Non-stochastic best arm identification and hyperparameter
// optimization", AISTATS 2016.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "coordinator/queue/study_costs.h"
#include "coordinator/search/trial_scores.h"
#include "parallax/v1/search.pb.h"

namespace parallax {

inline constexpr double kSecondsPerHour = 3600;

// Returns the number of rungs that have ended: the default has a score of each.
int EndedRungs(const v1::SearchRecord& record);
// Returns the trials that take part in the next rung, the default first.
std::vector<v1::SearchTrial> Entrants(const v1::SearchRecord& record);

// Enters what the rung has shown of its trials, and says why those that go on to no further rung
// don't. `scores` has one for each entrant, by the names of variants; trials in `failed`, by name
// with the reason, have none. Errors: kFailedPrecondition if a score is missing; nothing is
// changed then.
absl::Status EndRung(const std::vector<TrialScore>& scores,
                     const std::map<std::string, std::string>& failed, v1::SearchRecord& record);

// Returns the core-hours that the next rung will take, from those of the last one, whose results
// cost `costs`: pairs that it has already are not made again. 0 if none follows.
double NextCoreHours(const v1::SearchRecord& record, const StudyCosts& costs);

// Returns why no further rung begins; empty while one may.
std::string WhyOver(const v1::SearchRecord& record);
// Returns the trial of the last rung that has ended with the least objective, of those that are not
// significantly worse than the default; 0 for that; nothing before.
std::optional<int> BestOf(const v1::SearchRecord& record);

// Returns the score that a record keeps.
v1::SearchScore ScoreOf(const TrialScore& score, int rung);

}  // namespace parallax
