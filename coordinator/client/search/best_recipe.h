// The best recipe of a search as a study file of its own. Pure.
#pragma once

#include <string>

#include "common/base/status.h"
#include "parallax/v1/search.pb.h"

namespace parallax::client {

// Returns the text of a study with the best trial as its only variant, with the search's pairs,
// training and evaluation. It stands alone: what the search's base and `set` say is in it.
// `search` needs its trials and its study. Errors: kFailedPrecondition while no trial is the best.
absl::StatusOr<std::string> BestRecipe(const v1::SearchStatus& search);

}  // namespace parallax::client
