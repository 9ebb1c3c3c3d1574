#include "coordinator/queue/tables/stream_table.h"

#include "common/base/status.h"
#include "coordinator/queue/database/compress.h"

namespace parallax {

absl::Status KeepStreamIn(SqliteConnection& db, const v1::StreamRecord& record) {
  return db.Run(
      "INSERT INTO streams(name, record) VALUES (?1, ?2) ON CONFLICT DO UPDATE SET record = ?2",
      record.study().name(), SqlBlob{PackMessage(record)});
}

absl::Status RemoveStreamIn(SqliteConnection& db, const std::string& name) {
  return db.Run("DELETE FROM streams WHERE name = ?1", name);
}

absl::StatusOr<std::vector<v1::StreamRecord>> StreamsIn(SqliteConnection& db) {
  std::vector<v1::StreamRecord> records;
  SqliteQuery query(db, "SELECT name, record FROM streams ORDER BY name");
  while (query.Next()) {
    RETURN_IF_ERROR(WithContext(UnpackMessage(query.Blob(1), records.emplace_back()),
                                "the record of stream " + std::string(query.Text(0))));
  }
  RETURN_IF_ERROR(query.status());
  return records;
}

}  // namespace parallax
