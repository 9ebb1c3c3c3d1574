// Pictures and maps of published pairs in forms that a browser shows: small JPEGs and plain arrays.
// What was made stays in memory up to a bound. At most two are made at a time, so that a wall of
// pictures doesn't take the coordinator's cores. Thread-safe.
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
  // `store` outlives it; null: every call is kNotFound. `cache_bytes`: of what is kept.
  explicit Pictures(const Store* store, size_t cache_bytes = 64 << 20);

  // A JPEG of the PNG at `path`, `width_px` wide, or as wide as the image is if that is less.
  // Errors: kNotFound for a file that isn't there; kInvalidArgument for one that is no picture; the
  // store's.
  absl::StatusOr<std::string> Jpeg(const std::string& path, int width_px);
  // The map at `path` (.exr: one float32 a pixel; .png: one uint16) as bytes: width and height as
  // uint32, then the rows from the top; all little-endian. Errors: as Jpeg.
  absl::StatusOr<std::string> Map(const std::string& path);
  // A file as it is. Errors: as Jpeg.
  absl::StatusOr<std::string> File(const std::string& path) const;

 private:
  class Turn;  // While one lives, one of the places of those who make is taken.

  std::string Cached(const std::string& key);
  void Keep(const std::string& key, const std::string& bytes);

  const Store* const store_;
  const size_t cache_bytes_;
  // Those who make take turns; at most kMakers at a time.
  std::mutex turns_mu_;
  std::condition_variable turn_;
  int making_ = 0;  // Guarded by turns_mu_.

  std::mutex mu_;
  // Guarded by mu_.
  std::list<std::pair<std::string, std::string>> newest_;  // Used last comes first.
  std::map<std::string, decltype(newest_)::iterator> by_key_;
  size_t bytes_ = 0;
};

}  // namespace parallax
