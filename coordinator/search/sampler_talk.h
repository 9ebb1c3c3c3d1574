// What a sampler is asked, and its answer, as JSON. Pure and thread-safe.
//
// Asked: {"schema": "parallax-sampler-1", "seed", "count", "space": [{"path", "low", "high", "log",
// "integer"} or {"path", "choices": [YAML texts]}, both with "when": [{"path", "values"}] where
// they are varied only there], "history": [{"number", "values": {PATH: number or YAML text},
// "objective", "low", "high", "difference"} or with "failed": REASON in place of figures]}. The
// objective is an error: less is better. Answered: {"trials": [{PATH: number or YAML text}]}.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "coordinator/search/trial_scores.h"
#include "coordinator/search/trial_space.h"

namespace parallax {

// Returns the question for `count` more trials. `scores` and `failed` are those of EndRung.
std::string AskText(const v1::SearchRecord& record, const std::vector<TrialScore>& scores,
                    const std::map<std::string, std::string>& failed, int count);

// Returns the trials of an answer, at most `count`, numbered after those of the record. Values of
// fields whose conditions fail are left out; so are trials that are there already, so that none may
// be left. Errors: kInvalidArgument that names the trial and the field, for an answer that is none,
// values outside of the space, or a config that the rules forbid.
absl::StatusOr<std::vector<v1::SearchTrial>> AnsweredTrials(const v1::SearchRecord& record,
                                                            const std::string& answer, int count);

}  // namespace parallax
