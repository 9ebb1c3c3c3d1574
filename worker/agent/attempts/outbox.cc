#include "worker/agent/attempts/outbox.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>

#include "common/base/hash.h"
#include "common/base/names.h"
#include "common/base/system/file.h"
#include "common/base/system/log.h"
#include "common/store/store.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr char kLockName[] = "/lock";
constexpr char kStagingName[] = "/staging";
constexpr char kComplete[] = ".complete";
constexpr char kFail[] = ".fail";
constexpr size_t kDigestBytes = 32;

// The descriptor that holds the folder's lock, or -1 when a living process has it.
absl::StatusOr<int> LockFolder(const std::string& directory) {
  const std::string path = directory + kLockName;
  while (true) {
    const int fd = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (fd < 0) return ErrnoError(errno, "open " + path);
    if (flock(fd, LOCK_EX | LOCK_NB) != 0) {
      const int error = errno;
      close(fd);
      if (error == EWOULDBLOCK) return -1;
      return ErrnoError(error, "lock " + path);
    }
    // Another process took over a dead worker's folder and removed it: a lock on a file without a
    // name protects nothing.
    struct stat held;
    struct stat named;
    if (fstat(fd, &held) == 0 && stat(path.c_str(), &named) == 0 && held.st_ino == named.st_ino) {
      return fd;
    }
    close(fd);
    std::error_code ignored;
    fs::create_directories(directory, ignored);
  }
}

// Whether it is a report that a dead worker had not finished writing.
bool IsUnfinished(const fs::path& path) { return path.filename().string().rfind(".tmp-", 0) == 0; }

// Makes the folder and its parents durably.
absl::Status MakeFolder(const fs::path& directory) {
  std::vector<fs::path> made;
  std::error_code error;
  for (fs::path at = directory; !at.empty() && !fs::exists(at, error); at = at.parent_path()) {
    made.push_back(at);
  }
  fs::create_directories(directory, error);
  if (error) return ErrnoError(error.value(), "make outbox " + directory.string());
  for (const fs::path& path : made) {
    RETURN_IF_ERROR(SyncPath(path.has_parent_path() ? path.parent_path().string() : "."));
  }
  return absl::OkStatus();
}

bool IsReportName(const std::string& extension) {
  return extension == kComplete || extension == kFail;
}

std::string DigestOf(const std::string& bytes) {
  const Sha256Digest digest = Sha256Of(bytes);
  return std::string(digest.begin(), digest.end());
}

absl::StatusOr<Report> ReadReport(const fs::path& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path.string()));
  if (bytes.size() < kDigestBytes ||
      DigestOf(bytes.substr(kDigestBytes)) != bytes.substr(0, kDigestBytes)) {
    return DataLoss("{}: content does not match its digest", path.string());
  }
  Report report;
  const std::string message = bytes.substr(kDigestBytes);
  bool parsed;
  if (path.extension() == kComplete) {
    parsed = report.body.emplace<v1::CompleteRequest>().ParseFromString(message);
  } else {
    parsed = report.body.emplace<v1::FailRequest>().ParseFromString(message);
  }
  if (!parsed) return DataLoss("{}: not a report", path.string());
  return report;
}

std::vector<fs::path> SortedEntries(const std::string& directory) {
  std::vector<fs::path> entries;
  std::error_code error;
  for (fs::directory_iterator it(directory, error), end; !error && it != end; it.increment(error)) {
    entries.push_back(it->path());
  }
  std::sort(entries.begin(), entries.end());
  return entries;
}

}  // namespace

const v1::AttemptId& Report::attempt() const {
  return std::visit([](const auto& body) -> const v1::AttemptId& { return body.attempt(); }, body);
}

const std::string& Report::coordinator_id() const {
  return std::visit([](const auto& body) -> const std::string& { return body.coordinator_id(); },
                    body);
}

absl::Status CheckWorkerName(std::string_view name) { return CheckName("worker name", name); }

absl::StatusOr<std::unique_ptr<Outbox>> Outbox::Open(const std::string& root,
                                                     const std::string& worker) {
  RETURN_IF_ERROR(CheckWorkerName(worker));
  const std::string directory = root + "/" + worker;
  RETURN_IF_ERROR(MakeFolder(directory));
  std::error_code error;
  ASSIGN_OR_RETURN(const int lock_fd, LockFolder(directory));
  if (lock_fd < 0) {
    return AlreadyExists(
        "outbox {} is in use by another worker named {}; give this one another --name", directory,
        worker);
  }
  std::unique_ptr<Outbox> outbox(new Outbox(directory, lock_fd));
  for (const fs::path& sibling : SortedEntries(root)) {
    if (fs::is_directory(sibling, error) && sibling.filename() != worker) {
      outbox->AdoptFrom(sibling.string());
    }
  }
  fs::remove_all(directory + kStagingName, error);
  for (const fs::path& path : SortedEntries(directory)) {
    if (IsUnfinished(path)) fs::remove(path, error);
  }
  RETURN_IF_ERROR(SyncPath(directory));
  outbox->LoadLeftovers();
  return outbox;
}

Outbox::~Outbox() { close(lock_fd_); }

// Moves the reports of a dead worker here and removes its folder.
void Outbox::AdoptFrom(const std::string& sibling) {
  if (access((sibling + kLockName).c_str(), F_OK) != 0) return;  // Not an outbox.
  const absl::StatusOr<int> lock_fd = LockFolder(sibling);
  if (!lock_fd.ok() || *lock_fd < 0) return;
  std::error_code error;
  for (const fs::path& path : SortedEntries(sibling)) {
    if (IsReportName(path.extension().string())) {
      fs::rename(path, fs::path(directory_) / path.filename(), error);
    } else if (IsUnfinished(path)) {
      fs::remove(path, error);
    }
  }
  fs::remove_all(sibling + kStagingName, error);
  fs::remove(sibling + kLockName, error);
  fs::remove(sibling, error);  // Not empty: stays with its unknown files.
  close(*lock_fd);
}

void Outbox::LoadLeftovers() {
  for (const fs::path& path : SortedEntries(directory_)) {
    if (!IsReportName(path.extension().string())) continue;
    absl::StatusOr<Report> report = ReadReport(path);
    if (report.ok()) {
      leftovers_.push_back(*std::move(report));
      continue;
    }
    LogError("report in the outbox is damaged and set aside", {{"error", report.status()}});
    std::error_code error;
    fs::rename(path, path.string() + ".damaged", error);
  }
}

std::string Outbox::PathOf(const Report& report) const {
  // The coordinator's name can have any form; eight digits of its hash distinguish databases.
  return fmt::format("{}/{}-{}-{}{}", directory_, Sha256Hex(report.coordinator_id()).substr(0, 8),
                     report.attempt().job_id(), report.attempt().fence(),
                     report.body.index() == 0 ? kComplete : kFail);
}

std::string Outbox::staging() const { return directory_ + kStagingName; }

absl::Status Outbox::Put(const Report& report) {
  const std::string message =
      std::visit([](const auto& body) { return body.SerializeAsString(); }, report.body);
  return WriteFileAtomically(PathOf(report), DigestOf(message) + message);
}

absl::Status Outbox::Remove(const Report& report) {
  const std::string path = PathOf(report);
  // Not synced: if the entry returns after a crash, its report is answered ALREADY_DONE.
  if (unlink(path.c_str()) != 0 && errno != ENOENT) return ErrnoError(errno, "remove " + path);
  return absl::OkStatus();
}

}  // namespace parallax
