#include "common/base/edit_distance.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace parallax {
namespace {

char Lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

}  // namespace

size_t EditDistance(std::string_view a, std::string_view b, bool ignore_case) {
  const auto same = [&](char x, char y) { return ignore_case ? Lower(x) == Lower(y) : x == y; };
  // row[j]: the distance from what of `a` has been read to the first j letters of `b`.
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t replaced = diagonal + (same(a[i], b[j]) ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

std::string NearestName(std::string_view name, const std::vector<std::string>& known) {
  int best_distance = std::max(2, static_cast<int>(name.size()) / 3) + 1;
  std::string best;
  for (const std::string& candidate : known) {
    const int distance = static_cast<int>(EditDistance(name, candidate));
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

std::string NearestHint(std::string_view name, const std::vector<std::string>& known) {
  const std::string best = NearestName(name, known);
  return best.empty() ? "" : ", did you mean " + best + "?";
}

}  // namespace parallax
