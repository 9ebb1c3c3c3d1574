// A limit on the memory of this process, checked before large allocations: a scene that is too big
// then fails with a message, before the system kills the whole worker. One limit for the process;
// thread-safe. All sizes are bytes.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/base/status.h"

namespace parallax {

// Sets the limit. 0 or less, the default, stands for the machine's memory or, if less, the limit of
// the process's control group (a container, a service, a batch job).
void SetMemoryLimit(int64_t bytes);
// Returns the limit that counts now, in bytes.
int64_t MemoryLimit();

// Returns the smallest memory limit, in bytes, of the control groups that `groups` names (the text
// of /proc/self/cgroup) and of their ancestors; 0 if none has a limit. `root` is the mount point of
// the cgroup file systems.   Source: cgroups(7), "Documentation/admin-guide/cgroup-v2.rst".
int64_t CgroupMemoryLimit(const std::string& groups, const std::string& root);

// Returns the bytes of memory that the process holds now (its resident set).
int64_t ResidentMemory();

// Returns OK if about `more_bytes` fit beside the memory in use.
// Errors: kResourceExhausted, "`what`: needs about ... MB beside ... MB in use; the limit is ...
// MB".
absl::Status CheckMemory(std::string_view what, int64_t more_bytes);

// Adds up what this thread asks of CheckMemory while the object lives: what a file takes in memory
// when it is decoded. The innermost object counts; its sum goes on to the one around it.
class MemoryRequests {
 public:
  MemoryRequests();
  ~MemoryRequests();
  MemoryRequests(const MemoryRequests&) = delete;
  MemoryRequests& operator=(const MemoryRequests&) = delete;

  int64_t bytes() const { return bytes_; }

 private:
  friend absl::Status CheckMemory(std::string_view what, int64_t more_bytes);

  MemoryRequests* outer_;
  int64_t bytes_ = 0;
};

}  // namespace parallax
