// Short texts of a search that its table and its picture share. Pure functions.
#pragma once

#include <string>
#include <vector>

#include "parallax/v1/search.pb.h"

namespace parallax::client {

// Returns the value's text in three digits where it is a number of a range; "" if the trial has
// none.
std::string ValueText(const v1::SearchTrial& trial, const v1::SearchField& field);
// Returns a short name for each field of the space: the last part of its path, or as many parts as
// tell it from the others.
std::vector<std::string> ShortNames(const v1::SearchSpec& search);
// Returns the trials as a table has them: the default, then those that came farthest, the least
// error first.
std::vector<const v1::SearchTrial*> InOrder(const v1::SearchStatus& search);
// Returns one line on where the search is: "rung 2 of 3, 9 of 16 trials, 4.1 core-hours".
std::string SearchProgress(const v1::SearchStatus& search);

}  // namespace parallax::client
