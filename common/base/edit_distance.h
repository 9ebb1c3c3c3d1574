// How far two names are apart: what "did you mean ..." goes by. Pure functions.
#pragma once

#include <cstddef>
#include <string_view>

namespace parallax {

// The least number of letters to insert, delete or replace that leads from one to the other. Upper
// and lower case are the same letter if `ignore_case` (ASCII).   Source: Levenshtein 1966, by rows.
size_t EditDistance(std::string_view a, std::string_view b, bool ignore_case = false);

}  // namespace parallax
