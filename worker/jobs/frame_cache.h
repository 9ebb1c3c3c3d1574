// Frames of a store that this machine does not see as a folder, brought here once and kept for the
// next training, within a bound. A file's name says its hash, so that a damaged one is noticed and
// brought again. Several workers may share a cache.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/store/store.h"

namespace parallax {

struct FrameCacheOptions {
  std::string dir;                        // Made if need be.
  int64_t max_bytes = int64_t{20} << 30;  // The oldest frames give way.
};

struct LocalFile {
  std::string path;
  int64_t size = 0;
  std::string sha256;  // Lower-case hex.
};

// Thread-safe.
class FrameCache {
 public:
  explicit FrameCache(FrameCacheOptions options) : options_(std::move(options)) {}

  // Returns those files of `names` that the frame `path` of the store has, by name. Errors: the
  // store's and the disk's; kDataLoss for a file that comes in another size than the store says;
  // kNotFound for a frame without any file.
  absl::StatusOr<std::map<std::string, LocalFile>> Fetch(
      const Store& store, const std::string& path, const std::vector<std::string>& names) const;
  // Removes the frames that were used longest ago until the rest fits.
  void Trim() const;

 private:
  absl::StatusOr<LocalFile> FetchFile(const Store& store, const std::string& path, int64_t size,
                                      const std::string& dir, const std::string& name) const;

  const FrameCacheOptions options_;
};

// As Fetch, for a frame in a folder of this machine. Errors: as reading the files.
absl::StatusOr<std::map<std::string, LocalFile>> FilesOfFrame(
    const std::string& dir, const std::vector<std::string>& names);

}  // namespace parallax
