// Where attempts' outputs live: a tree of folders that workers fill and that is never changed after
// publication. Paths are relative ("<key>/.attempt-<fence>/003/left.png"), '/'-separated, and
// confined to the store.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"

namespace parallax {

struct StoreEntry {
  std::string path;
  int64_t size = 0;
};

struct StoreFile {
  int64_t size = 0;
  std::string sha256;  // Lower-case hex.
};

// Thread-safe.
class Store {
 public:
  virtual ~Store() = default;
  // "file:///abs/dir", "s3://bucket/prefix?..."
  virtual std::string Uri() const = 0;
  // In the marker of a folder's root; "" where a store needs none.
  virtual std::string Id() const { return ""; }
  // Durable when it returns: data and directory entries are on disk, or nothing is there.
  // Errors of all here: kInvalidArgument as CheckStorePath; kNotFound for what isn't there;
  // kPermissionDenied, kResourceExhausted and kUnavailable as the disk or the service says.
  virtual absl::Status Put(std::string_view path, std::string_view bytes) = 0;
  // As Put, of a file of this machine with these facts; the same file again costs nothing or
  // little. With `may_move` the local file may be gone afterwards. Errors: kDataLoss when what
  // arrives isn't what `facts` say.
  virtual absl::Status PutFile(std::string_view path, const std::string& local_path,
                               const StoreFile& facts, bool may_move);
  // Errors: those of Put; kNotFound.
  virtual absl::StatusOr<std::string> Get(std::string_view path) const = 0;
  // At most `max_bytes` from `offset` on; "" at the end. Errors: those of Get.
  virtual absl::StatusOr<std::string> GetPiece(std::string_view path, int64_t offset,
                                               size_t max_bytes) const = 0;
  // Files below `prefix`; none when it isn't there. Errors: those of Put.
  virtual absl::StatusOr<std::vector<StoreEntry>> List(std::string_view prefix) const = 0;
  // What isn't there is removed already. Errors: those of Put.
  virtual absl::Status RemoveTree(std::string_view path) = 0;
  // The local folder of a path. Errors: kFailedPrecondition when the store is not a directory of
  // this machine.
  virtual absl::StatusOr<std::string> LocalPath(std::string_view path) const = 0;
};

// Errors: kInvalidArgument unless the path is relative, normal, without "..", empty parts, NUL or
// backslash, and without the store's own names (".tmp-...", ".parallax-store").
absl::Status CheckStorePath(std::string_view path);

struct StoreOptions {
  // Make the folder, and its marker if it is new. Without, a folder that is absent or has no
  // marker is refused: it is likely a shared disk that is not mounted.
  bool create = true;
  // Not empty: the marker must say this.
  std::string id;
  // Only to read from: whether it can be written is not tried.
  bool read_only = false;
};

// "file:///abs/dir", a plain path, or "s3://bucket/prefix?endpoint=..." (see s3_store.h).
// Errors name the folder and the cause: kNotFound for an absent folder or marker,
// kFailedPrecondition for the marker of another store.
absl::StatusOr<std::unique_ptr<Store>> OpenStore(std::string_view uri,
                                                 const StoreOptions& options = {});

// fsync of a file or folder by path. Errors: as open(2) and fsync(2), naming it.
absl::Status SyncPath(const std::string& path);
// Writes the file whole or not at all: temporary name in the same folder, fsync, rename, fsync of
// the folder. Errors: as WriteFile and rename(2), naming the path.
absl::Status WriteFileAtomically(const std::string& path, std::string_view bytes);

}  // namespace parallax
