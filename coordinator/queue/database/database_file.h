// Opens the queue's database file safely: for one coordinator at a time, on a local disk only. The
// pragmas that durability depends on are read back and checked.
#pragma once

#include <memory>
#include <string>

#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"

namespace parallax {

// An advisory lock on "<db>.lock" for the life of this object. The kernel releases it if the
// process dies.
class DatabaseLock {
 public:
  // Takes the lock. Errors: kFailedPrecondition if another coordinator holds it, in this process or
  // in another one, which the message names.
  static absl::StatusOr<std::unique_ptr<DatabaseLock>> Acquire(const std::string& db_path);
  ~DatabaseLock();
  DatabaseLock(const DatabaseLock&) = delete;
  DatabaseLock& operator=(const DatabaseLock&) = delete;

 private:
  explicit DatabaseLock(int fd) : fd_(fd) {}
  int fd_;
};

// Returns the name of the network file system with this statfs f_type; null for a local one.
const char* NetworkFileSystem(long f_type);
// Checks that the database's folder is on a local file system. Errors: kFailedPrecondition for a
// network file system, whose locks and fsync are not reliable.
absl::Status CheckLocalFileSystem(const std::string& db_path);

// Opens the one connection that writes: WAL, synchronous=FULL, foreign keys, no trusted schema, no
// mmap, and checkpoints only when we ask for them. Errors: the database's; kInternal if a pragma
// does not hold.
absl::StatusOr<std::unique_ptr<SqliteConnection>> OpenWriter(const std::string& path,
                                                             const std::string& vfs);
// Opens a query_only connection, which never checkpoints. Errors: the database's.
absl::StatusOr<std::unique_ptr<SqliteConnection>> OpenReader(const std::string& path,
                                                             const std::string& vfs);

}  // namespace parallax
