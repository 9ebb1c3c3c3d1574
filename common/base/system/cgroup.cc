#include "common/base/system/cgroup.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>

namespace parallax {
namespace {

// Microseconds of CPU time in each period, over the period; 0 at "max" and -1, which are no limit.
double QuotaIn(const std::string& folder) {
  double quota = 0, period = 0;
  if (std::ifstream in(folder + "/cpu.max"); in >> quota >> period) return quota / period;
  std::ifstream(folder + "/cpu.cfs_quota_us") >> quota;
  std::ifstream(folder + "/cpu.cfs_period_us") >> period;
  return quota > 0 && period > 0 ? quota / period : 0;
}

}  // namespace

std::vector<std::string> CgroupFolders(std::string_view groups, const std::string& root,
                                       const std::string& controller) {
  std::vector<std::string> folders;
  std::istringstream lines{std::string(groups)};
  for (std::string line; std::getline(lines, line);) {
    const size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const bool named = ("," + controllers + ",").find("," + controller + ",") != std::string::npos;
    if (!controllers.empty() && !named) continue;
    const std::string top = controllers.empty() ? root : root + "/" + controller;
    std::string group = line.substr(second + 1);
    for (; !group.empty();
         group.erase(group.find_last_of('/') == std::string::npos ? 0 : group.find_last_of('/'))) {
      folders.push_back(top + group);
    }
    folders.push_back(top);
  }
  return folders;
}

double CgroupCpuLimit(std::string_view groups, const std::string& root) {
  double smallest = 0;
  for (const std::string& folder : CgroupFolders(groups, root, "cpu")) {
    const double quota = QuotaIn(folder);
    if (quota > 0) smallest = smallest > 0 ? std::min(smallest, quota) : quota;
  }
  return smallest;
}

std::string OwnCgroups() {
  std::ifstream file("/proc/self/cgroup");
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace parallax
