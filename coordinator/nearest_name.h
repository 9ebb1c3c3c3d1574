// Finds the name that a mistyped word was probably meant to be, for the programs' messages.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace parallax {

// Returns how many letters must be put in, left out or replaced to make `b` of `a`.
inline size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0]++;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

// Returns the first of the names that are nearest to `typed`; "" if none is within two letters.
inline std::string NearestOf(const std::vector<std::string>& names, std::string_view typed) {
  std::string nearest;
  size_t best = 3;
  for (const std::string& name : names) {
    if (const size_t distance = EditDistance(typed, name); distance < best) {
      best = distance;
      nearest = name;
    }
  }
  return nearest;
}

}  // namespace parallax
