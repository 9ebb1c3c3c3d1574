// Ranges of the figures in workers' results. They are kept for later studies by their key, so what
// no honest worker can have is refused. Pure functions.
#pragma once

#include <fmt/core.h>
#include <google/protobuf/map.h>

#include <cmath>
#include <limits>
#include <string>

namespace parallax {

inline constexpr double kLongestS = 1e9;  // 31 years.

// Returns why a figure is none in [low, high]; empty if it is. `what`: "a loss".
inline std::string WhyNotIn(const char* what, double value, double low, double high) {
  if (value >= low && value <= high) return "";
  return fmt::format("{} of {}, allowed is [{}, {}]", what, value, low, high);
}

// Returns why figures by name are none: more than 64, a name that is not [a-z][a-z0-9_]* of at most
// 64 characters, or a value that is not in [low, high]. Empty if they are.
inline std::string WhyBadFigures(const char* what,
                                 const google::protobuf::Map<std::string, double>& figures,
                                 double low = std::numeric_limits<double>::lowest(),
                                 double high = std::numeric_limits<double>::max()) {
  constexpr size_t kMost = 64, kLongest = 64;
  if (figures.size() > kMost) {
    return fmt::format("{} {}, allowed are at most {}", figures.size(), what, kMost);
  }
  for (const auto& [name, value] : figures) {
    const bool is_name =
        !name.empty() && name.size() <= kLongest && name[0] >= 'a' && name[0] <= 'z' &&
        name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
    if (!is_name) return fmt::format("{} with a name that is none", what);
    if (!(value >= low && value <= high)) {
      return fmt::format("{} {} of {}, allowed is [{}, {}]", what, name, value, low, high);
    }
  }
  return "";
}

}  // namespace parallax
