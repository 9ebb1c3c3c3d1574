// Opens the queue's database file safely: for one coordinator at a time, on a local disk only. The
// pragmas that durability depends on are read back and checked.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "common/base/status.h"
#include "coordinator/queue/database/sqlite.h"

namespace parallax {

// The right to open a database file, for the life of this object. It is held on the file itself
// (device and inode), so that it holds under every name of the file: links, bind mounts, other
// paths. "<db>.lock" is held as well: it names the holder's process, and older programs look there.
// The kernel releases both if the process dies.
class DatabaseLock {
 public:
  // Takes the lock, before anything of the file is read. Makes an empty file if none exists.
  // Errors: kFailedPrecondition if another coordinator holds it, in this process or in another one,
  // which the message names, or if the file has several names (hard links), because SQLite keeps
  // its log beside one of them; kDataLoss if the log must be there and is not.
  static absl::StatusOr<std::unique_ptr<DatabaseLock>> Acquire(const std::string& db_path);
  ~DatabaseLock();
  // Notes in "<db>.lock" whether the log has commits that the file lacks, so that it must be there
  // if this process is killed. Say so after the first commit; PutLogAway takes it back. Errors:
  // those of the file system.
  absl::Status NoteLog(bool is_needed);
  DatabaseLock(const DatabaseLock&) = delete;
  DatabaseLock& operator=(const DatabaseLock&) = delete;

 private:
  DatabaseLock() = default;
  absl::Status TakeName(const std::string& db_path);
  absl::Status TakeFile(const std::string& db_path);

  std::string name_;  // "<db>.lock".
  int name_fd_ = -1;
  int file_fd_ = -1;
  std::pair<uint64_t, uint64_t> file_{};  // Device and inode.
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
// Puts the whole log into the file, and notes that. Then closing `db`, a writer that is the last
// connection, removes the log; without this it stays. Errors: kUnavailable while others read, or if
// the disk errs; those of NoteLog.
absl::Status PutLogAway(SqliteConnection& db, DatabaseLock& lock);
// Opens a query_only connection, which never checkpoints. Errors: the database's.
absl::StatusOr<std::unique_ptr<SqliteConnection>> OpenReader(const std::string& path,
                                                             const std::string& vfs);

}  // namespace parallax
