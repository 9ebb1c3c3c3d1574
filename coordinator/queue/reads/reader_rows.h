// Rules that all readers of the queue share. Private to coordinator/queue. Pure functions.
#pragma once

#include <string>

#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"

namespace parallax {

inline constexpr int kMostRows = 10'000;  // Most rows in one answer.

// Returns the number of rows to read: `asked`, but at most kMostRows; `otherwise` if `asked` is 0.
int RowLimit(int asked, int otherwise);

// Makes an error. Errors: always kNotFound, "<what>: no such".
absl::Status NoSuch(const std::string& what);

// Steps to the query's first row. Errors: kNotFound of NoSuch if it has none; the query's.
absl::Status FirstRow(SqliteQuery& query, const std::string& what);

}  // namespace parallax
