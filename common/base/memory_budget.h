// How much memory this process may use, so that a scene that is too big fails with a message before
// the machine kills the whole worker. One number for the process; thread-safe.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/status.h"

namespace parallax {

// 0 or less: the machine's memory, or what the process's control group (a container, a service, a
// batch job) may use if that is less (the default).
void SetMemoryLimit(int64_t bytes);
int64_t MemoryLimit();

// The smallest memory limit, in bytes, of the control groups that `groups` names (the text of
// /proc/self/cgroup) and of all above them; 0 when none has one. `root` is where the cgroup file
// systems are mounted.   Source: cgroups(7), "Documentation/admin-guide/cgroup-v2.rst".
int64_t CgroupMemoryLimit(const std::string& groups, const std::string& root);

// What the process holds now.
int64_t ResidentMemory();

// OK when about `more_bytes` fit beside what the process holds.
// Errors: kResourceExhausted: "`what`: needs about ... MB beside ... MB in use; the limit is ...
// MB".
absl::Status CheckMemory(std::string_view what, int64_t more_bytes);

}  // namespace parallax
