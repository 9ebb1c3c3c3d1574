// Groups of pairs: pairs of one set share cameras, scenes and the way their truth was made, so that
// they say less of other pictures than as many independent ones. Tables show a figure for each
// group, and intervals draw groups instead of pairs.
#pragma once

#include <string>
#include <vector>

namespace parallax {

// With fewer groups, intervals draw pairs: so few say nothing of the spread between groups.
inline constexpr int kFewestGroups = 5;

// Returns the groups of pairs by their names: what comes before the first '_' ("mb2006_rocks1").
// Empty strings if that makes one group of all, or no group of two.
std::vector<std::string> GroupsByName(const std::vector<std::string>& names);

// Returns for each pair the unit that intervals draw it with, numbered from 0 in order: its group,
// or a unit of its own where `groups` has an empty string or less than kFewestGroups units.
std::vector<int> UnitsOf(const std::vector<std::string>& groups);

}  // namespace parallax
