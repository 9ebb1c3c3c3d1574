// A search for people: its trials, how much each setting matters, the best recipe and whether it
// was confirmed. Pure functions.
#pragma once

#include <string>
#include <vector>

#include "coordinator/client/views/terminal.h"
#include "parallax/v1/search.pb.h"

namespace parallax::client {

// Returns the whole search as lines: its state, table, importances, best trial, confirmation.
std::vector<std::string> SearchLines(const v1::SearchStatus& search, const Terminal& terminal);
// Prints a table of searches without trials.
void PrintSearches(const v1::ListSearchesReply& reply, const Terminal& out);

}  // namespace parallax::client
