#include "common/base/system/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

#include "common/base/system/memory_budget.h"
#include "common/base/system/sought_files.h"

namespace parallax {

absl::StatusOr<std::string> ReadFile(const std::string& path, size_t max_bytes) {
  NoteSought(path);
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return ErrnoError(errno, "open " + path);
  std::string bytes;
  struct stat info {};
  if (::fstat(fd, &info) == 0 && S_ISREG(info.st_mode)) {
    const size_t size = std::min(static_cast<size_t>(info.st_size) + 1, max_bytes);
    constexpr size_t kSmall = 16 << 20;  // Fits whenever anything does.
    if (size > kSmall) {
      if (absl::Status fits = CheckMemory(path, static_cast<int64_t>(size)); !fits.ok()) {
        ::close(fd);
        return fits;
      }
    }
    bytes.reserve(size);
  }
  char buffer[1 << 16];
  ssize_t count;
  int error_number = 0;
  while ((count = ::read(fd, buffer, sizeof(buffer))) != 0) {
    if (count < 0) {
      if (errno == EINTR) continue;
      error_number = errno;
      break;
    }
    bytes.append(buffer, static_cast<size_t>(count));
    if (bytes.size() > max_bytes) break;
  }
  ::close(fd);
  if (error_number != 0) return ErrnoError(error_number, "read " + path);
  if (bytes.size() > max_bytes) {
    return ResourceExhausted("read {}: larger than {} bytes", path, max_bytes);
  }
  return bytes;
}

absl::Status WriteFile(const std::string& path, std::string_view bytes, bool sync) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) return ErrnoError(errno, "open " + path);
  absl::Status status;
  while (!bytes.empty() && status.ok()) {
    const ssize_t count = ::write(fd, bytes.data(), bytes.size());
    if (count >= 0) {
      bytes.remove_prefix(static_cast<size_t>(count));
    } else if (errno != EINTR) {
      status = ErrnoError(errno, "write " + path);
    }
  }
  if (status.ok() && sync && ::fsync(fd) != 0) status = ErrnoError(errno, "fsync " + path);
  if (::close(fd) != 0 && status.ok()) status = ErrnoError(errno, "close " + path);
  struct stat info {};
  if (!status.ok() && ::stat(path.c_str(), &info) == 0 && S_ISREG(info.st_mode)) {
    ::unlink(path.c_str());
  }
  return status;
}

absl::StatusOr<DiskSpace> SpaceOfDisk(const std::string& path) {
  struct statvfs disk {};
  if (statvfs(path.c_str(), &disk) != 0) return ErrnoError(errno, path);
  const auto bytes = [&](auto blocks) {
    return static_cast<int64_t>(blocks) * static_cast<int64_t>(disk.f_frsize);
  };
  return DiskSpace{bytes(disk.f_bavail), bytes(disk.f_blocks)};
}

absl::Status MakeFolders(const std::string& dir) {
  std::error_code error;
  std::filesystem::create_directories(dir, error);
  return error ? ErrnoError(error.value(), "make " + dir) : absl::OkStatus();
}

void HoldStandardStreams() {
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    // The lowest descriptor that is free is the one that is closed.
    if (::fcntl(fd, F_GETFD) < 0 && errno == EBADF) (void)::open("/dev/null", O_RDONLY);
  }
}

}  // namespace parallax
