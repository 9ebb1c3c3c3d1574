#include "common/base/system/memory_budget.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

namespace parallax {
namespace {

std::atomic<int64_t> limit_bytes{0};

int64_t MachineMemory() {
  static const int64_t machine = [] {
    const int64_t bytes = static_cast<int64_t>(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGE_SIZE);
    std::ifstream file("/proc/self/cgroup");
    const std::string groups((std::istreambuf_iterator<char>(file)), {});
    const int64_t group = CgroupMemoryLimit(groups, "/sys/fs/cgroup");
    return group > 0 ? std::min(bytes, group) : bytes;
  }();
  return machine;
}

// The smallest limit in `file` of `root`/`group` and of the groups above it, up to `root` itself.
int64_t SmallestLimit(const std::string& root, std::string group, const char* file) {
  int64_t smallest = 0;
  for (;;) {
    std::ifstream in(root + group + "/" + file);
    int64_t limit = 0;  // Stays so at "max".
    if (in >> limit && limit > 0) smallest = smallest > 0 ? std::min(smallest, limit) : limit;
    if (group.empty()) return smallest;
    group.erase(group.find_last_of('/') == std::string::npos ? 0 : group.find_last_of('/'));
  }
}

}  // namespace

int64_t CgroupMemoryLimit(const std::string& groups, const std::string& root) {
  std::istringstream lines(groups);
  int64_t smallest = 0;
  for (std::string line; std::getline(lines, line);) {
    const size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const std::string group = line.substr(second + 1);
    const int64_t limit = controllers.empty() ? SmallestLimit(root, group, "memory.max")
                          : ("," + controllers + ",").find(",memory,") != std::string::npos
                              ? SmallestLimit(root + "/memory", group, "memory.limit_in_bytes")
                              : 0;
    if (limit > 0) smallest = smallest > 0 ? std::min(smallest, limit) : limit;
  }
  return smallest;
}

void SetMemoryLimit(int64_t bytes) { limit_bytes = bytes; }

int64_t MemoryLimit() {
  const int64_t bytes = limit_bytes;
  return bytes > 0 ? bytes : MachineMemory();
}

int64_t ResidentMemory() {
  std::ifstream file("/proc/self/statm");
  int64_t total = 0, resident = 0;
  file >> total >> resident;
  return resident * sysconf(_SC_PAGE_SIZE);
}

absl::Status CheckMemory(std::string_view what, int64_t more_bytes) {
  const int64_t held = ResidentMemory();
  const int64_t limit = MemoryLimit();
  if (more_bytes <= limit && held <= limit - more_bytes) return absl::OkStatus();
  return ResourceExhausted("{}: needs about {} MB beside {} MB in use; the limit is {} MB", what,
                           more_bytes >> 20, held >> 20, limit >> 20);
}

}  // namespace parallax
