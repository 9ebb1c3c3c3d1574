#include "common/store/store.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/store/local_store.h"
#include "common/store/s3_store.h"

namespace parallax {

absl::Status CheckStorePath(std::string_view path) {
  const auto broken = [&](std::string_view why) {
    std::string shown(path.substr(0, 200));
    for (char& c : shown) {
      if (static_cast<unsigned char>(c) < 0x20) c = '?';
    }
    return InvalidArgument("store path \"{}\": {}", shown, why);
  };
  if (path.empty()) return broken("empty");
  if (path.size() > 1024) return broken("longer than 1024 characters");
  if (path.front() == '/') return broken("absolute, allowed is relative to the store");
  if (path.find('\0') != std::string_view::npos) return broken("holds a NUL");
  if (path.find('\\') != std::string_view::npos) return broken("holds a backslash");
  for (std::string_view rest = path; true;) {
    const size_t slash = rest.find('/');
    const std::string_view part = rest.substr(0, slash);
    if (part.empty()) return broken("an empty part");
    if (part == "." || part == "..") return broken("a part that is . or ..");
    if (part.size() > 255) return broken("a part longer than 255 characters");
    if (part.substr(0, kTemporaryPrefix.size()) == kTemporaryPrefix || part == kStoreMarker ||
        part == kStoreOwner) {
      return broken("a name that the store keeps for itself");
    }
    if (slash == std::string_view::npos) return absl::OkStatus();
    rest.remove_prefix(slash + 1);
  }
}

absl::Status Store::SetOwner(const std::string&) {
  return Unimplemented("a store without a marker belongs to nobody");
}

absl::Status Store::PutFile(std::string_view path, const std::string& local_path,
                            const StoreFile& facts, bool) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(local_path));
  if (static_cast<int64_t>(bytes.size()) != facts.size || Sha256Hex(bytes) != facts.sha256) {
    return DataLoss("{}: its content is not what its manifest says", local_path);
  }
  return Put(path, bytes);
}

absl::StatusOr<bool> Store::Has(std::string_view path) const {
  const absl::Status status = GetPiece(path, 0, 1).status();
  if (absl::IsNotFound(status)) return false;
  RETURN_IF_ERROR(status);
  return true;
}

absl::StatusOr<std::unique_ptr<Store>> OpenStore(std::string_view uri,
                                                 const StoreOptions& options) {
  constexpr std::string_view kFile = "file://";
  if (uri.substr(0, kFile.size()) == kFile) {
    const std::string_view folder = uri.substr(kFile.size());
    if (folder.empty() || folder.front() != '/') {
      return InvalidArgument("store {}: allowed is file:///an/absolute/folder", uri);
    }
    return OpenLocalStore(std::string(folder), options);
  }
  if (uri.rfind("s3://", 0) == 0) {
    ASSIGN_OR_RETURN(const S3Options s3, ParseS3Uri(uri));
    return OpenS3Store(s3, options);
  }
  if (uri.find("://") != std::string_view::npos) {
    return InvalidArgument("store {}: allowed is a folder, file:///a/folder or s3://bucket/prefix",
                           uri);
  }
  if (uri.empty()) return InvalidArgument("store: no folder given");
  return OpenLocalStore(std::string(uri), options);
}

absl::Status SyncPath(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return ErrnoError(errno, "open " + path);
  const int result = ::fsync(fd);
  const int error_number = errno;
  ::close(fd);
  return result == 0 ? absl::OkStatus() : ErrnoError(error_number, "fsync " + path);
}

absl::Status WriteFileAtomically(const std::string& path, std::string_view bytes) {
  static std::atomic<uint64_t> counter{0};  // Two threads may write the same path.
  const size_t slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  const std::string temporary =
      fmt::format("{}.tmp-{}-w{}", slash == std::string::npos ? "" : folder, ::getpid(), ++counter);
  const absl::Status written = WriteFile(temporary, bytes, /*sync=*/true);
  if (!written.ok()) {  // Name what the caller asked for, not our temporary file.
    std::string message(ToStd(written.message()));
    const size_t at = message.find(temporary);
    if (at != std::string::npos) message.replace(at, temporary.size(), path);
    return MakeError(written.code(), message);
  }
  if (std::rename(temporary.c_str(), path.c_str()) != 0) {
    const absl::Status status = ErrnoError(errno, "rename to " + path);
    ::unlink(temporary.c_str());
    return status;
  }
  return SyncPath(folder);
}

}  // namespace parallax
