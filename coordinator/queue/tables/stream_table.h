// The table of streams: endless studies and how far their consumers have come. The queue only keeps
// the records; coordinator/stream reads them.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"
#include "parallax/v1/stream.pb.h"

namespace parallax {

// Keeps the record under the name of its study, in place of an earlier one. Errors: the database's.
absl::Status KeepStreamIn(SqliteConnection& db, const v1::StreamRecord& record);
// Removes the record of that name, if it is there. Errors: the database's.
absl::Status RemoveStreamIn(SqliteConnection& db, const std::string& name);
// Returns all records, by name. Errors: the database's; kDataLoss for a record that is none.
absl::StatusOr<std::vector<v1::StreamRecord>> StreamsIn(SqliteConnection& db);

}  // namespace parallax
