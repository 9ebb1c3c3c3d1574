#include "coordinator/queue/database/database_file.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/file.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

namespace parallax {
namespace {

std::string FolderOf(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

std::string HolderOf(int fd) {
  char text[64] = {};
  const ssize_t n = pread(fd, text, sizeof(text) - 1, 0);
  return n > 0 ? std::string(text, static_cast<size_t>(n)) : "unknown";
}

absl::Status AssertPragma(SqliteConnection& db, const char* sql, std::string_view wanted) {
  ASSIGN_OR_RETURN(const std::string seen, db.Text(sql));
  if (seen == wanted) return absl::OkStatus();
  return Internal("{}: {}, wanted {}", sql, seen, wanted);
}

absl::Status Configure(SqliteConnection& db, bool writer) {
  sqlite3_db_config(db.raw(), SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  // Readers may not checkpoint even by closing; the writer's last close may.
  sqlite3_db_config(db.raw(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, writer ? 0 : 1, nullptr);
  sqlite3_busy_timeout(db.raw(), writer ? 0 : 1000);
  if (writer) RETURN_IF_ERROR(db.Text("PRAGMA journal_mode = WAL").status());
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
  const std::string path = db_path + ".lock";
  const int fd = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) return ErrnoError(errno, "open " + path);
  std::unique_ptr<DatabaseLock> lock(new DatabaseLock(fd));
  if (flock(fd, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return ErrnoError(errno, "lock " + path);
    return FailedPrecondition("database {} is open in another coordinator (process {})", db_path,
                              HolderOf(fd));
  }
  const std::string holder = std::to_string(getpid());
  if (ftruncate(fd, 0) != 0 || pwrite(fd, holder.data(), holder.size(), 0) < 0) {
    return ErrnoError(errno, "write " + path);
  }
  return lock;
}

DatabaseLock::~DatabaseLock() { close(fd_); }

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
  RETURN_IF_ERROR(WithContext(Configure(*db, true), path));
  return db;
}

absl::StatusOr<std::unique_ptr<SqliteConnection>> OpenReader(const std::string& path,
                                                             const std::string& vfs) {
  ASSIGN_OR_RETURN(auto db, SqliteConnection::Open(path, SqliteConnection::Mode::kReadOnly, vfs));
  RETURN_IF_ERROR(WithContext(Configure(*db, false), path));
  return db;
}

}  // namespace parallax
