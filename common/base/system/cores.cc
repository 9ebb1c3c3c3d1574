#include "common/base/system/cores.h"

#include <sched.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "common/base/system/cgroup.h"

namespace parallax {
int UsableCores() {
  cpu_set_t set;
  const int bound = sched_getaffinity(0, sizeof set, &set) == 0
                        ? CPU_COUNT(&set)
                        : static_cast<int>(std::thread::hardware_concurrency());
  static const double quota = CgroupCpuLimit(OwnCgroups(), "/sys/fs/cgroup");
  const int cores = quota > 0 ? std::min(bound, static_cast<int>(std::ceil(quota))) : bound;
  return std::max(1, cores);
}

}  // namespace parallax
