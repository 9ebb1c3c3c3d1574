// Rules that all readers of the queue share. Private to coordinator/queue.
#pragma once

#include <string>

#include "common/base/status.h"

namespace parallax {

inline constexpr int kMostRows = 10'000;  // In one answer.

// The number of rows to read: `asked`, at most kMostRows; `otherwise` where nothing is asked for.
int RowLimit(int asked, int otherwise);

// kNotFound: "<what>: no such".
absl::Status NoSuch(const std::string& what);

}  // namespace parallax
