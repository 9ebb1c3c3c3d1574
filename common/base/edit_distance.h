// The distance between two names, for messages with "did you mean ...". Pure functions.
#pragma once

#include <cstddef>
#include <string_view>

namespace parallax {

// Returns the least number of letters to insert, delete or replace to turn one name into the other.
// With `ignore_case`, upper and lower case (ASCII) are the same. Takes time proportional to the
// product of the lengths.
// Source: Levenshtein, "Binary codes capable of correcting deletions, insertions, and reversals",
// 1966.
size_t EditDistance(std::string_view a, std::string_view b, bool ignore_case = false);

}  // namespace parallax
