#include "common/base/memory_budget.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <string>

namespace parallax {
namespace {

std::atomic<int64_t> limit_bytes{0};

int64_t MachineMemory() {
  static const int64_t machine = [] {
    int64_t bytes = static_cast<int64_t>(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGE_SIZE);
    std::ifstream file("/sys/fs/cgroup/memory.max");
    int64_t container = 0;
    if (file >> container && container > 0) bytes = std::min(bytes, container);
    return bytes;
  }();
  return machine;
}

}  // namespace

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
  return MakeError(absl::StatusCode::kResourceExhausted,
                   std::string(what) + ": needs about " + std::to_string(more_bytes >> 20) +
                       " MB beside " + std::to_string(held >> 20) + " MB in use; the limit is " +
                       std::to_string(limit >> 20) + " MB");
}

}  // namespace parallax
