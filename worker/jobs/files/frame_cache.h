// A local cache of frames from a store that this machine does not see as a folder, kept for the
// next training up to a bound. File names contain hashes, so that damaged files are detected and
// fetched again. Several workers may share a cache.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/store/store.h"

namespace parallax {

// Where the cache is, and its size.
struct FrameCacheOptions {
  std::string dir;                        // Made if missing.
  int64_t max_bytes = int64_t{20} << 30;  // The oldest frames are removed first.
};

// A file in the cache.
struct LocalFile {
  std::string path;
  int64_t size = 0;
  std::string sha256;  // Lower-case hex.
};

// Thread-safe.
class FrameCache {
 public:
  explicit FrameCache(FrameCacheOptions options) : options_(std::move(options)) {}

  // Fetches those files of `names` that the frame `path` of the store has, and returns them by
  // name. Errors: the store's and the disk's; kDataLoss when a file's size differs from the
  // store's; kNotFound for a frame without any file.
  absl::StatusOr<std::map<std::string, LocalFile>> Fetch(
      const Store& store, const std::string& path, const std::vector<std::string>& names) const;
  // Removes the least recently used frames until the cache fits its bound.
  void Trim() const;

 private:
  absl::StatusOr<LocalFile> FetchFile(const Store& store, const std::string& path, int64_t size,
                                      const std::string& dir, const std::string& name) const;

  const FrameCacheOptions options_;
};

// Returns those files of `names` that a frame in a folder of this machine has. Errors: those of
// reading the files.
absl::StatusOr<std::map<std::string, LocalFile>> FilesOfFrame(
    const std::string& dir, const std::vector<std::string>& names);

}  // namespace parallax
