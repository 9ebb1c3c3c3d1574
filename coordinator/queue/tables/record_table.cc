#include "coordinator/queue/tables/record_table.h"

#include <fmt/core.h>

#include "coordinator/queue/database/compress.h"

namespace parallax {

absl::Status KeepRecordIn(SqliteConnection& db, const std::string& table, const std::string& name,
                          const google::protobuf::MessageLite& record) {
  const std::string sql = fmt::format(
      "INSERT INTO {}(name, record) VALUES (?1, ?2) ON CONFLICT DO UPDATE SET record = ?2", table);
  return db.Run(sql.c_str(), name, SqlBlob{PackMessage(record)});
}

absl::Status RemoveRecordIn(SqliteConnection& db, const std::string& table,
                            const std::string& name) {
  return db.Run(fmt::format("DELETE FROM {} WHERE name = ?1", table).c_str(), name);
}

absl::Status ReadRecordsIn(SqliteConnection& db, const std::string& table,
                           const std::function<google::protobuf::MessageLite&()>& add) {
  const std::string sql = fmt::format("SELECT name, record FROM {} ORDER BY name", table);
  SqliteQuery query(db, sql.c_str());
  while (query.Next()) {
    RETURN_IF_ERROR(
        WithContext(UnpackMessage(query.Blob(1), add()),
                    fmt::format("the record of {} in {}", std::string(query.Text(0)), table)));
  }
  return query.status();
}

}  // namespace parallax
