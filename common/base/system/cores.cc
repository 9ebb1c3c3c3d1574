#include "common/base/system/cores.h"

#include <sched.h>

#include <algorithm>
#include <thread>

namespace parallax {

int UsableCores() {
  cpu_set_t set;
  if (sched_getaffinity(0, sizeof set, &set) == 0) return CPU_COUNT(&set);
  return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

}  // namespace parallax
