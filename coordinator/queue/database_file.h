// Opening the queue's database file safely: one coordinator at a time, local disk only, the pragmas
// that durability rests on asserted by reading them back.
#pragma once

#include <memory>
#include <string>

#include "common/base/status.h"
#include "coordinator/queue/sqlite.h"

namespace parallax {

// An advisory lock on "<db>.lock", held for the life of this object; the kernel drops it when the
// process dies.
class DatabaseLock {
 public:
  // kFailedPrecondition when another coordinator (also one in this process) holds it; names its
  // process.
  static absl::StatusOr<std::unique_ptr<DatabaseLock>> Acquire(const std::string& db_path);
  ~DatabaseLock();
  DatabaseLock(const DatabaseLock&) = delete;
  DatabaseLock& operator=(const DatabaseLock&) = delete;

 private:
  explicit DatabaseLock(int fd) : fd_(fd) {}
  int fd_;
};

// Name of the network file system with this statfs f_type, or null for a local one.
const char* NetworkFileSystem(long f_type);
// kFailedPrecondition if the file's folder is on a network file system: their locks and fsync can't
// be relied on.
absl::Status CheckLocalFileSystem(const std::string& db_path);

// The one connection that writes: WAL, synchronous=FULL, foreign keys, no trusted schema, no mmap,
// no checkpoints but ours.
absl::StatusOr<std::unique_ptr<SqliteConnection>> OpenWriter(const std::string& path,
                                                             const std::string& vfs);
// A query_only connection that never checkpoints.
absl::StatusOr<std::unique_ptr<SqliteConnection>> OpenReader(const std::string& path,
                                                             const std::string& vfs);

}  // namespace parallax
