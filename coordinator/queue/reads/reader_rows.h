// Rules that all readers of the queue share. Private to coordinator/queue. Pure functions.
#pragma once

#include <string>

#include "common/base/status.h"

namespace parallax {

inline constexpr int kMostRows = 10'000;  // Most rows in one answer.

// Returns the number of rows to read: `asked`, but at most kMostRows; `otherwise` if `asked` is 0.
int RowLimit(int asked, int otherwise);

// Makes an error. Errors: always kNotFound, "<what>: no such".
absl::Status NoSuch(const std::string& what);

}  // namespace parallax
