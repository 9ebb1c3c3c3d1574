// How much memory this process may use, so that a scene that is too big fails with a message before
// the machine kills the whole worker. One number for the process; thread-safe.
#pragma once

#include <cstdint>
#include <string_view>

#include "common/base/status.h"

namespace parallax {

// 0 or less: the machine's memory, or the container's if that is less (the default).
void SetMemoryLimit(int64_t bytes);
int64_t MemoryLimit();

// What the process holds now.
int64_t ResidentMemory();

// OK when about `more_bytes` fit beside what the process holds.
// Errors: kResourceExhausted: "`what`: needs about ... MB beside ... MB in use; the limit is ...
// MB".
absl::Status CheckMemory(std::string_view what, int64_t more_bytes);

}  // namespace parallax
