#include "coordinator/queue/database/backup.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sqlite3.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

#include "coordinator/queue/database/page_checksum.h"

namespace parallax {
namespace {

absl::Status CopyDatabase(SqliteConnection& source, const std::string& path) {
  ASSIGN_OR_RETURN(auto target,
                   SqliteConnection::Open(path, SqliteConnection::Mode::kReadWriteCreate));
  if (HasChecksums(source.raw())) ReserveChecksums(target->raw());
  sqlite3_backup* backup = sqlite3_backup_init(target->raw(), "main", source.raw(), "main");
  if (backup == nullptr) {
    return Internal("backup: {}", sqlite3_errmsg(target->raw()));
  }
  sqlite3_backup_step(backup, -1);
  const int code = sqlite3_backup_finish(backup);
  if (code == SQLITE_OK) return absl::OkStatus();
  if (code == SQLITE_IOERR_DATA) return DataLoss("backup to {}: {}", path, kWrongPage);
  return MakeError((code & 0xff) == SQLITE_FULL ? absl::StatusCode::kResourceExhausted
                                                : absl::StatusCode::kUnavailable,
                   fmt::format("backup to {}: {}", path, sqlite3_errstr(code)));
}

absl::Status SyncFile(const std::string& path) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return ErrnoError(errno, "open " + path);
  const int code = fsync(fd);
  const int error = errno;
  close(fd);
  return code == 0 ? absl::OkStatus() : ErrnoError(error, "fsync " + path);
}

}  // namespace

absl::Status BackUp(SqliteConnection& db, const std::string& path) {
  if (std::filesystem::exists(path)) {
    return AlreadyExists("backup {}: exists already", path);
  }
  const std::string temporary = path + ".partial";
  std::error_code ignored;
  std::filesystem::remove(temporary, ignored);
  absl::Status status = CopyDatabase(db, temporary);
  if (status.ok()) status = SyncFile(temporary);
  // The copy gets its name when it is whole and on disk. link refuses to replace a file that was
  // made meanwhile.
  if (status.ok() && link(temporary.c_str(), path.c_str()) != 0) {
    status = ErrnoError(errno, "backup " + path);
  }
  std::filesystem::remove(temporary, ignored);
  RETURN_IF_ERROR(status);
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return SyncFile(folder.empty() ? "." : folder);
}

}  // namespace parallax
