// A search as JSON, for `--json`, the page and scripts. Pure functions.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "parallax/v1/search.pb.h"

namespace parallax {

// Returns what the last rung of a trial has shown; null before the first has ended.
const v1::SearchScore* LastScore(const v1::SearchTrial& trial);
// Returns how many trials, without the default, are "open": they may go on, or came to the end;
// "dropped" by a rung's scores; "failed": they could not be made or trained.
std::map<std::string, int> TrialStates(const v1::SearchStatus& search);
// Returns whether trials tell that the setting matters: chance explains less in 39 of 40 cases.
bool IsSignificant(const v1::SearchImportance& importance);
// Returns the text of the value that the field has in the search's default: what the study's base
// and `set` say; "-" for a group of fields.
std::string DefaultText(const v1::SearchStatus& search, const std::string& path);

// Returns the search as a line of a list: states of its trials and its budget are absent where the
// status has no trials and no study.
nlohmann::ordered_json SearchLineJson(const v1::SearchStatus& search);
// Returns the line, the trials, the space and the importances.
nlohmann::ordered_json SearchJson(const v1::SearchStatus& search);

}  // namespace parallax
