#include "common/store/local_store.h"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <filesystem>
#include <utility>

#include "common/base/names.h"
#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/base/system/secret.h"

namespace parallax {
namespace {

class Descriptor {
 public:
  explicit Descriptor(int fd = -1) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  int get() const { return fd_; }

 private:
  int fd_;
};

std::vector<std::string> Parts(std::string_view path) {
  std::vector<std::string> parts;
  while (!path.empty()) {
    const size_t slash = path.find('/');
    parts.emplace_back(path.substr(0, slash));
    path.remove_prefix(slash == std::string_view::npos ? path.size() : slash + 1);
  }
  return parts;
}

std::string TemporaryName() {
  static std::atomic<uint64_t> counter{
      0};  // Unique within the process; the pid makes it so among them.
  return fmt::format("{}{}-{}", kTemporaryPrefix, ::getpid(), ++counter);
}

absl::Status WriteAll(int fd, std::string_view bytes, const std::string& what) {
  while (!bytes.empty()) {
    const ssize_t count = ::write(fd, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return ErrnoError(errno, "write " + what);
    bytes.remove_prefix(static_cast<size_t>(count));
  }
  return absl::OkStatus();
}

absl::Status Sync(int fd, const std::string& what) {
  return ::fsync(fd) == 0 ? absl::OkStatus() : ErrnoError(errno, "fsync " + what);
}

// Whole or not at all, durable: temporary file, fsync, rename, fsync of the folder.
absl::Status ReplaceFile(int folder_fd, const std::string& name, std::string_view bytes,
                         const std::string& shown) {
  const std::string temporary = TemporaryName();
  Descriptor file(::openat(folder_fd, temporary.c_str(),
                           O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644));
  if (file.get() < 0) return ErrnoError(errno, "write " + shown);
  absl::Status status = WriteAll(file.get(), bytes, shown);
  if (status.ok()) status = Sync(file.get(), shown);
  if (status.ok() && ::renameat(folder_fd, temporary.c_str(), folder_fd, name.c_str()) != 0) {
    status = ErrnoError(errno, "write " + shown);
  }
  if (!status.ok()) {
    ::unlinkat(folder_fd, temporary.c_str(), 0);
    return status;
  }
  return Sync(folder_fd, shown);
}

// Names in a folder, sorted, without "." and "..".
absl::StatusOr<std::vector<std::string>> NamesIn(int folder_fd, const std::string& shown) {
  // A descriptor of its own: fdopendir takes it over and moves its offset.
  const int fd = ::openat(folder_fd, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  DIR* dir = fd < 0 ? nullptr : ::fdopendir(fd);
  if (dir == nullptr) {
    const absl::Status status = ErrnoError(errno, "list " + shown);
    if (fd >= 0) ::close(fd);
    return status;
  }
  std::vector<std::string> names;
  errno = 0;
  while (const dirent* entry = ::readdir(dir)) {
    const std::string name = entry->d_name;
    if (name != "." && name != "..") names.push_back(name);
  }
  const int error_number = errno;
  ::closedir(dir);
  if (error_number != 0) return ErrnoError(error_number, "list " + shown);
  std::sort(names.begin(), names.end());
  return names;
}

// "" when none exists.
absl::StatusOr<std::string> ReadMarker(const std::string& folder) {
  const std::string path = folder + "/" + std::string(kStoreMarker);
  const absl::StatusOr<std::string> text = ReadFile(path, 4096);
  if (absl::IsNotFound(text.status())) return std::string();
  if (!text.ok()) return text.status();
  return ParseStoreMarker(*text, path);
}

class LocalStore final : public Store {
 public:
  LocalStore(std::string root, Descriptor root_fd, std::string id)
      : root_(std::move(root)), root_fd_(std::move(root_fd)), id_(std::move(id)) {}

  std::string Uri() const override { return "file://" + root_; }
  std::string Id() const override { return id_; }
  absl::Status CheckMarker() const override {
    ASSIGN_OR_RETURN(const std::string id, ReadMarker(root_));
    return CheckStoreId(root_, id, id_);
  }
  absl::StatusOr<std::string> Owner() const override {
    const absl::StatusOr<std::string> text = ReadFile(OwnerPath(), 4096);
    if (absl::IsNotFound(text.status())) return std::string();
    if (!text.ok()) return text.status();
    return text->substr(0, text->find('\n'));
  }
  absl::Status SetOwner(const std::string& database_id) override {
    return WriteFileAtomically(OwnerPath(), database_id + "\n");
  }

  absl::Status Put(std::string_view path, std::string_view bytes) override {
    RETURN_IF_ERROR(CheckStorePath(path));
    std::vector<std::string> parts = Parts(path);
    const std::string name = std::move(parts.back());
    parts.pop_back();
    ASSIGN_OR_RETURN(const Descriptor folder, OpenFolder(parts, /*make=*/true));
    return ReplaceFile(folder.get(), name, bytes, Shown(path));
  }

  absl::Status PutFile(std::string_view path, const std::string& local_path, const StoreFile& facts,
                       bool may_move) override {
    if (!may_move) return Store::PutFile(path, local_path, facts, false);
    RETURN_IF_ERROR(CheckStorePath(path));
    std::vector<std::string> parts = Parts(path);
    const std::string name = std::move(parts.back());
    parts.pop_back();
    RETURN_IF_ERROR(SyncPath(local_path));
    ASSIGN_OR_RETURN(const Descriptor folder, OpenFolder(parts, /*make=*/true));
    if (::renameat(AT_FDCWD, local_path.c_str(), folder.get(), name.c_str()) != 0) {
      if (errno == EXDEV) return Store::PutFile(path, local_path, facts, false);
      return ErrnoError(errno, "write " + Shown(path));
    }
    return Sync(folder.get(), Shown(path));
  }

  absl::StatusOr<std::string> Get(std::string_view path) const override {
    ASSIGN_OR_RETURN(const Descriptor file, OpenFile(path));
    std::string bytes;
    char buffer[1 << 16];
    for (ssize_t count; (count = ::read(file.get(), buffer, sizeof(buffer))) != 0;) {
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) return ErrnoError(errno, "read " + Shown(path));
      bytes.append(buffer, static_cast<size_t>(count));
    }
    return bytes;
  }

  absl::StatusOr<std::string> GetPiece(std::string_view path, int64_t offset,
                                       size_t max_bytes) const override {
    ASSIGN_OR_RETURN(const Descriptor file, OpenFile(path));
    std::string bytes(max_bytes, '\0');
    size_t have = 0;
    while (have < max_bytes) {
      const ssize_t count = ::pread(file.get(), bytes.data() + have, max_bytes - have,
                                    static_cast<off_t>(offset + static_cast<int64_t>(have)));
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) return ErrnoError(errno, "read " + Shown(path));
      if (count == 0) break;
      have += static_cast<size_t>(count);
    }
    bytes.resize(have);
    return bytes;
  }

  absl::StatusOr<std::vector<StoreEntry>> List(std::string_view prefix) const override {
    std::vector<std::string> parts;
    if (!prefix.empty()) {
      RETURN_IF_ERROR(CheckStorePath(prefix));
      parts = Parts(prefix);
    }
    absl::StatusOr<Descriptor> folder = OpenFolder(parts, /*make=*/false);
    std::vector<StoreEntry> entries;
    if (absl::IsNotFound(folder.status())) return entries;
    if (!folder.ok()) return folder.status();
    RETURN_IF_ERROR(ListInto(folder->get(), std::string(prefix), entries));
    std::sort(entries.begin(), entries.end(),
              [](const StoreEntry& a, const StoreEntry& b) { return a.path < b.path; });
    return entries;
  }

  absl::Status RemoveTree(std::string_view path) override {
    RETURN_IF_ERROR(CheckStorePath(path));
    std::vector<std::string> parts = Parts(path);
    const std::string name = std::move(parts.back());
    parts.pop_back();
    absl::StatusOr<Descriptor> folder = OpenFolder(parts, /*make=*/false);
    if (absl::IsNotFound(folder.status())) return absl::OkStatus();
    if (!folder.ok()) return folder.status();
    RETURN_IF_ERROR(RemoveIn(folder->get(), name, Shown(path)));
    return Sync(folder->get(), Shown(path));
  }

  absl::StatusOr<std::string> LocalPath(std::string_view path) const override {
    RETURN_IF_ERROR(CheckStorePath(path));
    return Shown(path);
  }

 private:
  std::string OwnerPath() const { return root_ + "/" + std::string(kStoreOwner); }
  std::string Shown(std::string_view path) const { return root_ + "/" + std::string(path); }

  absl::StatusOr<Descriptor> OpenFile(std::string_view path) const {
    RETURN_IF_ERROR(CheckStorePath(path));
    std::vector<std::string> parts = Parts(path);
    const std::string name = std::move(parts.back());
    parts.pop_back();
    ASSIGN_OR_RETURN(const Descriptor folder, OpenFolder(parts, /*make=*/false));
    Descriptor file(::openat(folder.get(), name.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
    if (file.get() < 0) return ErrnoError(errno, "read " + Shown(path));
    return file;
  }

  // With `make`, absent folders are made and their entries brought to disk.
  absl::StatusOr<Descriptor> OpenFolder(const std::vector<std::string>& parts, bool make) const {
    Descriptor folder(::openat(root_fd_.get(), ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (folder.get() < 0) return ErrnoError(errno, "open " + root_);
    std::string shown = root_;
    for (const std::string& part : parts) {
      shown += "/" + part;
      if (make) {
        if (::mkdirat(folder.get(), part.c_str(), 0755) == 0) {
          RETURN_IF_ERROR(Sync(folder.get(), shown));
        } else if (errno != EEXIST) {
          return ErrnoError(errno, "make folder " + shown);
        }
      }
      Descriptor next(
          ::openat(folder.get(), part.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
      if (next.get() < 0) {
        struct stat info {};
        if (::fstatat(folder.get(), part.c_str(), &info, AT_SYMLINK_NOFOLLOW) == 0 &&
            S_ISLNK(info.st_mode)) {
          return PermissionDenied("open {}: a symbolic link inside the store", shown);
        }
        return ErrnoError(errno, "open " + shown);
      }
      folder = std::move(next);
    }
    return folder;
  }

  absl::Status ListInto(int folder_fd, const std::string& prefix,
                        std::vector<StoreEntry>& entries) const {
    ASSIGN_OR_RETURN(const std::vector<std::string> names, NamesIn(folder_fd, Shown(prefix)));
    for (const std::string& name : names) {
      if (name.rfind(kTemporaryPrefix, 0) == 0 || name == kStoreMarker || name == kStoreOwner) {
        continue;
      }
      const std::string path = prefix.empty() ? name : prefix + "/" + name;
      struct stat info {};
      if (::fstatat(folder_fd, name.c_str(), &info, AT_SYMLINK_NOFOLLOW) != 0) {
        if (errno == ENOENT) continue;  // Removed meanwhile.
        return ErrnoError(errno, "list " + Shown(path));
      }
      if (S_ISREG(info.st_mode)) {
        entries.push_back({path, info.st_size, static_cast<double>(info.st_mtime)});
      }
      if (!S_ISDIR(info.st_mode)) continue;
      const Descriptor child(
          ::openat(folder_fd, name.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
      if (child.get() < 0) {
        if (errno == ENOENT) continue;
        return ErrnoError(errno, "list " + Shown(path));
      }
      RETURN_IF_ERROR(ListInto(child.get(), path, entries));
    }
    return absl::OkStatus();
  }

  static absl::Status RemoveIn(int folder_fd, const std::string& name, const std::string& shown) {
    if (::unlinkat(folder_fd, name.c_str(), 0) == 0 || errno == ENOENT) return absl::OkStatus();
    if (errno != EISDIR && errno != EPERM) return ErrnoError(errno, "remove " + shown);
    const Descriptor child(
        ::openat(folder_fd, name.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    if (child.get() < 0) return ErrnoError(errno, "remove " + shown);
    ASSIGN_OR_RETURN(const std::vector<std::string> names, NamesIn(child.get(), shown));
    for (const std::string& inner : names) {
      RETURN_IF_ERROR(RemoveIn(child.get(), inner, shown + "/" + inner));
    }
    if (::unlinkat(folder_fd, name.c_str(), AT_REMOVEDIR) != 0 && errno != ENOENT) {
      return ErrnoError(errno, "remove " + shown);
    }
    return absl::OkStatus();
  }

  const std::string root_;
  const Descriptor root_fd_;
  const std::string id_;
};

// Makes the marker with a new id, unless another process makes one at the same time: then that one
// stays, which others may have read already.
absl::Status MakeMarker(const std::string& folder) {
  ASSIGN_OR_RETURN(const std::string id, NewSecret());
  const std::string own = folder + "/" + TemporaryName();
  const std::string marker = folder + "/" + std::string(kStoreMarker);
  RETURN_IF_ERROR(WriteFileAtomically(own, StoreMarkerText(id)));
  const int linked = ::link(own.c_str(), marker.c_str());
  const int error = linked == 0 ? 0 : errno;
  const bool has_no_links = error == EPERM || error == EOPNOTSUPP || error == ENOSYS;
  if (has_no_links && ::rename(own.c_str(), marker.c_str()) == 0) return absl::OkStatus();
  ::unlink(own.c_str());
  return error == 0 || error == EEXIST ? absl::OkStatus() : ErrnoError(error, "make " + marker);
}

// The id in the marker, made with it if need be.
absl::StatusOr<std::string> TakeMarker(const std::string& folder, const StoreOptions& options) {
  ASSIGN_OR_RETURN(std::string id, ReadMarker(folder));
  if (id.empty() && options.create) {
    RETURN_IF_ERROR(MakeMarker(folder));
    ASSIGN_OR_RETURN(id, ReadMarker(folder));
  }
  RETURN_IF_ERROR(CheckStoreId(folder, id, options.id));
  return id;
}

constexpr std::string_view kMarkerHead = "{\"store\": \"";
constexpr std::string_view kMarkerTail = "\"}\n";

}  // namespace

std::string StoreMarkerText(std::string_view id) {
  return fmt::format("{}{}{}", kMarkerHead, id, kMarkerTail);
}

absl::StatusOr<std::string> ParseStoreMarker(std::string_view text, std::string_view where) {
  const size_t frame = kMarkerHead.size() + kMarkerTail.size();
  if (!text.starts_with(kMarkerHead) || text.size() <= frame || !text.ends_with(kMarkerTail)) {
    return DataLoss("{}: not the marker of a store", where);
  }
  return std::string(text.substr(kMarkerHead.size(), text.size() - frame));
}

absl::Status CheckStoreId(std::string_view store, std::string_view id, std::string_view wanted) {
  if (id.empty()) {
    return NotFound(
        "store {}: there is no {} in it, so it is not the coordinator's store; is the shared disk "
        "mounted here? Name another place with --store, or let the coordinator take the files "
        "itself (coordinator serve --store-access stream)",
        store, kStoreMarker);
  }
  if (wanted.empty() || id == wanted) return absl::OkStatus();
  return FailedPrecondition(
      "store {}: it is the store {}, wanted is {}; is the right disk mounted "
      "here?",
      store, id, wanted);
}

absl::StatusOr<std::unique_ptr<Store>> OpenLocalStore(const std::string& root,
                                                      const StoreOptions& options) {
  const std::string absolute =
      std::filesystem::path(std::filesystem::absolute(root)).lexically_normal();
  // The path travels to workers in messages, whose texts are UTF-8.
  if (!IsUtf8(absolute)) {
    return InvalidArgument("folder {}: its name is not UTF-8", Printable(absolute));
  }
  std::string folder = absolute;
  while (folder.size() > 1 && folder.back() == '/') folder.pop_back();
  std::error_code error;
  if (options.create) {
    std::filesystem::create_directories(folder, error);
    if (error) return ErrnoError(error.value(), "store " + folder);
  }
  Descriptor fd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (fd.get() < 0 && errno == ENOENT && !options.create) {
    return NotFound(
        "store {}: there is no such folder on this machine; mount the coordinator's store there, "
        "name another place with --store, or let the coordinator take the files itself "
        "(coordinator serve --store-access stream)",
        folder);
  }
  if (fd.get() < 0) return ErrnoError(errno, "store " + folder);

  // A full or read-only disk is found now rather than after the first hour of rendering.
  if (!options.read_only) {
    const std::string probe = TemporaryName();
    const absl::Status status = ReplaceFile(fd.get(), probe, "probe", folder);
    if (!status.ok()) return WithContext(status, "store");
    ::unlinkat(fd.get(), probe.c_str(), 0);
  }
  ASSIGN_OR_RETURN(std::string id, TakeMarker(folder, options));
  return std::make_unique<LocalStore>(folder, std::move(fd), std::move(id));
}

}  // namespace parallax
