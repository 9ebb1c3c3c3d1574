#include "worker/evaluate/pair_groups.h"

#include <map>
#include <numeric>
#include <set>

namespace parallax {

std::vector<std::string> GroupsByName(const std::vector<std::string>& names) {
  std::vector<std::string> groups;
  for (const std::string& name : names) groups.push_back(name.substr(0, name.find('_')));
  const std::set<std::string> different(groups.begin(), groups.end());
  if (different.size() < 2 || different.size() == names.size()) groups.assign(names.size(), "");
  return groups;
}

std::vector<int> UnitsOf(const std::vector<std::string>& groups) {
  std::map<std::string, int> by_group;
  std::vector<int> units;
  int count = 0;
  for (const std::string& group : groups) {
    const bool known = !group.empty() && !by_group.try_emplace(group, count).second;
    units.push_back(known ? by_group.at(group) : count++);
  }
  if (count < kFewestGroups) std::iota(units.begin(), units.end(), 0);
  return units;
}

}  // namespace parallax
