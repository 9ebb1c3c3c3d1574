// A search for people and scripts: its trials, how much each setting matters, the best recipe and
// whether it was confirmed. Pure functions.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "coordinator/client/views/terminal.h"
#include "parallax/v1/search.pb.h"

namespace parallax::client {

// Returns the text of the value that the field has in the search's default: what the study's base
// and `set` say; "-" for a group of fields.
std::string DefaultText(const v1::SearchStatus& search, const std::string& path);
// Returns the value's text in three digits where it is a number of a range; "" if the trial has
// none.
std::string ValueText(const v1::SearchTrial& trial, const v1::SearchField& field);
// Returns a short name for each field of the space: the last part of its path, or as many parts as
// tell it from the others.
std::vector<std::string> ShortNames(const v1::SearchSpec& search);
// Returns the trials as a table has them: the default, then those that came farthest, the least
// error first.
std::vector<const v1::SearchTrial*> InOrder(const v1::SearchStatus& search);

// Returns the whole search as lines: its state, table, importances, best trial, confirmation.
std::vector<std::string> SearchLines(const v1::SearchStatus& search, const Terminal& terminal);
// Returns one line on where the search is: "rung 2 of 3, 9 of 16 trials, 4.1 core-hours".
std::string SearchProgress(const v1::SearchStatus& search);
// Prints a table of searches without trials.
void PrintSearches(const v1::ListSearchesReply& reply, const Terminal& out);

nlohmann::ordered_json SearchJson(const v1::SearchStatus& search);

}  // namespace parallax::client
