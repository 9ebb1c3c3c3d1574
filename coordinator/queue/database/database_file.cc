#include "coordinator/queue/database/database_file.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <mutex>
#include <set>

#include "coordinator/queue/database/page_checksum.h"

namespace parallax {
namespace {

std::string FolderOf(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

constexpr std::string_view kNeedsLog = " log";

// "<process>", or "<process> log" where the log is needed.
std::string TextOf(int fd) {
  char text[64] = {};
  const ssize_t n = pread(fd, text, sizeof(text) - 1, 0);
  return n > 0 ? std::string(text, static_cast<size_t>(n)) : "unknown";
}
std::string HolderOf(int fd) {
  const std::string text = TextOf(fd);
  return text.substr(0, text.find(' '));
}

using FileId = std::pair<uint64_t, uint64_t>;

FileId FileIdOf(const struct stat& file) { return {file.st_dev, file.st_ino}; }

// The database files that this process holds.
struct HeldFiles {
  static inline std::mutex mutex;
  static inline std::set<FileId> all;  // Guarded by mutex.
};

absl::Status AssertPragma(SqliteConnection& db, const char* sql, std::string_view wanted) {
  ASSIGN_OR_RETURN(const std::string seen, db.Text(sql));
  if (seen == wanted) return absl::OkStatus();
  return Internal("{}: {}, wanted {}", sql, seen, wanted);
}

absl::Status Configure(SqliteConnection& db, bool writer) {
  sqlite3_db_config(db.raw(), SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  // Closing removes no log that is noted as needed: PutLogAway does.
  sqlite3_db_config(db.raw(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, nullptr);
  sqlite3_busy_timeout(db.raw(), writer ? 0 : 1000);
  // Execute runs the statement to its end: SQLite returns "wal" first and commits then, where a
  // disk may err.
  if (writer) RETURN_IF_ERROR(db.Execute("PRAGMA journal_mode = WAL"));
  RETURN_IF_ERROR(db.Execute(
      "PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON; PRAGMA trusted_schema = OFF;"
      "PRAGMA mmap_size = 0; PRAGMA wal_autocheckpoint = 0; PRAGMA temp_store = MEMORY;"));
  RETURN_IF_ERROR(db.Execute(writer ? "PRAGMA cache_size = -65536; PRAGMA secure_delete = OFF;"
                                    : "PRAGMA cache_size = -8192; PRAGMA query_only = ON;"));
  RETURN_IF_ERROR(AssertPragma(db, "PRAGMA journal_mode", "wal"));
  RETURN_IF_ERROR(AssertPragma(db, "PRAGMA synchronous", "2"));
  RETURN_IF_ERROR(AssertPragma(db, "PRAGMA foreign_keys", "1"));
  RETURN_IF_ERROR(AssertPragma(db, "PRAGMA trusted_schema", "0"));
  RETURN_IF_ERROR(AssertPragma(db, "PRAGMA wal_autocheckpoint", "0"));
  return AssertPragma(db, "PRAGMA query_only", writer ? "0" : "1");
}

}  // namespace

absl::StatusOr<std::unique_ptr<DatabaseLock>> DatabaseLock::Acquire(const std::string& db_path) {
  std::unique_ptr<DatabaseLock> lock(new DatabaseLock());
  RETURN_IF_ERROR(lock->TakeName(db_path));
  RETURN_IF_ERROR(lock->TakeFile(db_path));
  const bool needs_log = TextOf(lock->name_fd_).ends_with(kNeedsLog);
  std::error_code error;
  if (needs_log && std::filesystem::file_size(db_path, error) > 0 && !error &&
      !std::filesystem::exists(db_path + "-wal", error)) {
    return DataLoss(
        "database {}: its log {}-wal is gone, with what was acknowledged last; put it back, or, if "
        "you have put a backup back or opened the database with another program, remove {}.lock",
        db_path, db_path, db_path);
  }
  RETURN_IF_ERROR(lock->NoteLog(needs_log));
  return lock;
}

absl::Status DatabaseLock::NoteLog(bool is_needed) {
  const std::string text = std::to_string(getpid()) + std::string(is_needed ? kNeedsLog : "");
  if (ftruncate(name_fd_, 0) != 0 || pwrite(name_fd_, text.data(), text.size(), 0) < 0 ||
      fsync(name_fd_) != 0) {
    return ErrnoError(errno, "write " + name_);
  }
  return absl::OkStatus();
}

absl::Status DatabaseLock::TakeName(const std::string& db_path) {
  name_ = db_path + ".lock";
  name_fd_ = open(name_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (name_fd_ < 0) return ErrnoError(errno, "open " + name_);
  if (flock(name_fd_, LOCK_EX | LOCK_NB) == 0) return absl::OkStatus();
  if (errno != EWOULDBLOCK) return ErrnoError(errno, "lock " + name_);
  return FailedPrecondition("database {} is open in another coordinator (process {})", db_path,
                            HolderOf(name_fd_));
}

// flock and SQLite's locks (fcntl) don't see each other on a local disk. But closing any descriptor
// of a file drops all fcntl locks that its process has on it. So a file that this process holds
// already is not opened a second time, and file_fd_ outlives SQLite's connections.
absl::Status DatabaseLock::TakeFile(const std::string& db_path) {
  const auto is_open = [&db_path](const std::string& where) {
    return FailedPrecondition("database {} is open in another coordinator ({})", db_path, where);
  };
  const std::lock_guard guard(HeldFiles::mutex);
  struct stat file {};
  if (stat(db_path.c_str(), &file) == 0 && HeldFiles::all.count(FileIdOf(file)) > 0) {
    return is_open("of this process");
  }
  file_fd_ = open(db_path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file_fd_ < 0) return ErrnoError(errno, "open " + db_path);
  if (fstat(file_fd_, &file) != 0) return ErrnoError(errno, "look at " + db_path);
  if (flock(file_fd_, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return ErrnoError(errno, "lock " + db_path);
    return is_open("under another name of this file");
  }
  if (file.st_nlink > 1) {
    return FailedPrecondition(
        "database {}: the file has {} names (hard links), and what is not yet in it lies beside "
        "one "
        "of them; remove the others",
        db_path, file.st_nlink);
  }
  file_ = FileIdOf(file);
  HeldFiles::all.insert(file_);
  return absl::OkStatus();
}

DatabaseLock::~DatabaseLock() {
  if (file_fd_ >= 0) {
    const std::lock_guard guard(HeldFiles::mutex);
    HeldFiles::all.erase(file_);
    close(file_fd_);
  }
  if (name_fd_ >= 0) close(name_fd_);
}

const char* NetworkFileSystem(long f_type) {
  const struct {
    unsigned long magic;
    const char* name;
  } kinds[] = {
      {0x6969, "NFS"},        {0x517B, "SMB"},       {0xFF534D42, "CIFS"},   {0xFE534D42, "SMB2"},
      {0x01021997, "9p"},     {0x00C36400, "Ceph"},  {0x0BD00BD0, "Lustre"}, {0x47504653, "GPFS"},
      {0x19830326, "BeeGFS"}, {0x5346414F, "AFS"},   {0x6B414653, "AFS"},    {0x73757245, "Coda"},
      {0x65735546, "FUSE"},   {0xAAD7AAEA, "PanFS"}, {0x01161970, "GFS2"},   {0x7461636F, "OCFS2"}};
  for (const auto& kind : kinds) {
    if ((static_cast<unsigned long>(f_type) & 0xFFFFFFFFul) == kind.magic) return kind.name;
  }
  return nullptr;
}

absl::Status CheckLocalFileSystem(const std::string& db_path) {
  struct statfs fs;
  const std::string folder = FolderOf(db_path);
  if (statfs(folder.c_str(), &fs) != 0) return ErrnoError(errno, "database folder " + folder);
  if (const char* name = NetworkFileSystem(fs.f_type)) {
    return FailedPrecondition(
        "database {} is on a network file system ({}), whose locks can't be relied on; put it on a "
        "local disk",
        db_path, name);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<SqliteConnection>> OpenWriter(const std::string& path,
                                                             const std::string& vfs) {
  ASSIGN_OR_RETURN(auto db,
                   SqliteConnection::Open(path, SqliteConnection::Mode::kReadWriteCreate, vfs));
  ReserveChecksums(db->raw());
  RETURN_IF_ERROR(WithContext(Configure(*db, true), path));
  return db;
}

absl::Status PutLogAway(SqliteConnection& db, DatabaseLock& lock) {
  const int code =
      sqlite3_wal_checkpoint_v2(db.raw(), nullptr, SQLITE_CHECKPOINT_TRUNCATE, nullptr, nullptr);
  if (code != SQLITE_OK) return Unavailable("checkpoint: {}", sqlite3_errmsg(db.raw()));
  RETURN_IF_ERROR(lock.NoteLog(false));
  sqlite3_db_config(db.raw(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 0, nullptr);
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<SqliteConnection>> OpenReader(const std::string& path,
                                                             const std::string& vfs) {
  ASSIGN_OR_RETURN(auto db, SqliteConnection::Open(path, SqliteConnection::Mode::kReadOnly, vfs));
  RETURN_IF_ERROR(WithContext(Configure(*db, false), path));
  return db;
}

}  // namespace parallax
