// The tables of records by name, which the queue only keeps: `streams` (endless studies and how far
// their consumers have come) and `searches` (over settings, and their trials). coordinator/stream
// and coordinator/search read the records.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"
#include "google/protobuf/message_lite.h"

namespace parallax {

inline constexpr char kStreamTable[] = "streams";
inline constexpr char kSearchTable[] = "searches";

// Keeps the record under the name, in place of an earlier one. Errors: the database's.
absl::Status KeepRecordIn(SqliteConnection& db, const std::string& table, const std::string& name,
                          const google::protobuf::MessageLite& record);
// Removes the record of that name, if it is there. Errors: the database's.
absl::Status RemoveRecordIn(SqliteConnection& db, const std::string& table,
                            const std::string& name);
// Reads all records, by name, into the messages that `add` makes. Errors: the database's; kDataLoss
// for a record that is none.
absl::Status ReadRecordsIn(SqliteConnection& db, const std::string& table,
                           const std::function<google::protobuf::MessageLite&()>& add);

// Returns all records, by name. Errors: those of ReadRecordsIn.
template <typename Record>
absl::StatusOr<std::vector<Record>> RecordsIn(SqliteConnection& db, const std::string& table) {
  std::vector<Record> records;
  RETURN_IF_ERROR(ReadRecordsIn(db, table, [&]() -> Record& { return records.emplace_back(); }));
  return records;
}

}  // namespace parallax
