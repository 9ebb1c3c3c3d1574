// The distance between two names and the nearest of many, for messages with "did you mean ...".
// Pure functions.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace parallax {

// Returns the least number of letters to insert, delete or replace to turn one name into the other.
// With `ignore_case`, upper and lower case (ASCII) are the same. Takes time proportional to the
// product of the lengths.
// Source: Levenshtein, "Binary codes capable of correcting deletions, insertions, and reversals",
// 1966.
size_t EditDistance(std::string_view a, std::string_view b, bool ignore_case = false);

// Returns the known name that `name` was probably meant to be; "" if none is similar: more
// than a third of its letters (and more than 2) differ.
std::string NearestName(std::string_view name, const std::vector<std::string>& known);
// Returns ", did you mean X?"; "" if no known name is similar.
std::string NearestHint(std::string_view name, const std::vector<std::string>& known);

}  // namespace parallax
