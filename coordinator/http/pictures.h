// Converts pictures and maps of published pairs for browsers, into small JPEGs and plain arrays,
// and caches them in memory up to a bound. At most two are converted at a time, so that a page full
// of pictures does not take all of the coordinator's cores. Thread-safe.
#pragma once

#include <condition_variable>
#include <list>
#include <map>
#include <mutex>
#include <string>

#include "common/base/status.h"
#include "common/store/store.h"

namespace parallax {

class Pictures {
 public:
  // `store` must outlive the object; if it is null, every call is kNotFound. `cache_bytes` bounds
  // the cache.
  explicit Pictures(const Store* store, size_t cache_bytes = 64 << 20);

  // Returns a JPEG of the PNG at `path` in the store, at most `width_px` wide. Errors: kNotFound
  // for a missing file; kInvalidArgument for a file that is not a picture; the store's.
  absl::StatusOr<std::string> Jpeg(const std::string& path, int width_px);
  // Returns the map at `path` (.exr: one float32 a pixel; .png: one uint16) as bytes: width and
  // height as uint32, then the rows from the top, all little-endian. Errors: those of Jpeg.
  absl::StatusOr<std::string> Map(const std::string& path);
  // Returns a file as it is. Errors: those of Jpeg.
  absl::StatusOr<std::string> File(const std::string& path) const;
  // Returns a JPEG of the normals at `path` (.exr with three channels from -1 to 1): red, green and
  // blue are x, y and z, each from 0 to 255. Errors: those of Jpeg.
  absl::StatusOr<std::string> Normals(const std::string& path);

 private:
  class Turn;  // Takes one of kMakers places for conversions while it lives.

  std::string Cached(const std::string& key);
  void Keep(const std::string& key, const std::string& bytes);

  const Store* const store_;
  const size_t cache_bytes_;
  // Bounds the number of conversions at a time to kMakers.
  std::mutex turns_mu_;
  std::condition_variable turn_;
  int making_ = 0;  // Guarded by turns_mu_.

  std::mutex mu_;
  // Guarded by mu_.
  std::list<std::pair<std::string, std::string>> newest_;  // The last used one comes first.
  std::map<std::string, decltype(newest_)::iterator> by_key_;
  size_t bytes_ = 0;
};

}  // namespace parallax
