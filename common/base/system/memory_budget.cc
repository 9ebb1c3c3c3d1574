#include "common/base/system/memory_budget.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <string>
#include <utility>

#include "common/base/system/cgroup.h"

namespace parallax {
namespace {

std::atomic<int64_t> limit_bytes{0};
thread_local MemoryRequests* innermost_requests = nullptr;

int64_t MachineMemory() {
  static const int64_t machine = [] {
    const int64_t bytes = static_cast<int64_t>(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGE_SIZE);
    const int64_t group = CgroupMemoryLimit(OwnCgroups(), "/sys/fs/cgroup");
    return group > 0 ? std::min(bytes, group) : bytes;
  }();
  return machine;
}

}  // namespace

int64_t CgroupMemoryLimit(const std::string& groups, const std::string& root) {
  int64_t smallest = 0;
  for (const std::string& folder : CgroupFolders(groups, root, "memory")) {
    for (const char* file : {"/memory.max", "/memory.limit_in_bytes"}) {
      int64_t limit = 0;  // Stays so at "max".
      std::ifstream(folder + file) >> limit;
      if (limit > 0) smallest = smallest > 0 ? std::min(smallest, limit) : limit;
    }
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

MemoryRequests::MemoryRequests() : outer_(std::exchange(innermost_requests, this)) {}

MemoryRequests::~MemoryRequests() {
  if (outer_ != nullptr) outer_->bytes_ += bytes_;
  innermost_requests = outer_;
}

absl::Status CheckMemory(std::string_view what, int64_t more_bytes) {
  if (innermost_requests != nullptr) innermost_requests->bytes_ += more_bytes;
  const int64_t held = ResidentMemory();
  const int64_t limit = MemoryLimit();
  if (more_bytes <= limit && held <= limit - more_bytes) return absl::OkStatus();
  return ResourceExhausted("{}: needs about {} MB beside {} MB in use; the limit is {} MB", what,
                           more_bytes >> 20, held >> 20, limit >> 20);
}

}  // namespace parallax
