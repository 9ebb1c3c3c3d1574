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

// Thread-safe.
class Store {
 public:
  virtual ~Store() = default;
  // "file:///abs/dir"
  virtual std::string Uri() const = 0;
  // Durable when it returns: data and directory entries are on disk, or nothing is there.
  virtual absl::Status Put(std::string_view path, std::string_view bytes) = 0;
  virtual absl::StatusOr<std::string> Get(std::string_view path) const = 0;
  virtual absl::StatusOr<std::vector<StoreEntry>> List(std::string_view prefix) const = 0;
  virtual absl::Status RemoveTree(std::string_view path) = 0;
  // The local folder of a path when the store is a directory of this machine, else
  // kFailedPrecondition.
  virtual absl::StatusOr<std::string> LocalPath(std::string_view path) const = 0;
};

// kInvalidArgument unless the path is relative, normal, without "..", empty parts, NUL or
// backslash.
absl::Status CheckStorePath(std::string_view path);

// "file:///abs/dir" or a plain path. Makes the folder. Errors name the folder and the cause.
absl::StatusOr<std::unique_ptr<Store>> OpenStore(std::string_view uri);

// fsync of a file or folder by path.
absl::Status SyncPath(const std::string& path);
// Writes the file whole or not at all: temporary name in the same folder, fsync, rename, fsync of
// the folder.
absl::Status WriteFileAtomically(const std::string& path, std::string_view bytes);

}  // namespace parallax
