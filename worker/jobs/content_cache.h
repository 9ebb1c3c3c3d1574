// The user's own content (common/store/content.h) on this machine: below the picture root, where
// the operator has brought it, or in a cache, where it comes out of the store once. Several workers
// may share a cache; each file is checked by its hash before it is used.
//
//   <dir>/<hash of the list>-<last part of the path>/<last part of the path>/<files>
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "common/store/content.h"
#include "parallax/v1/jobs.pb.h"

namespace parallax {

class Store;

struct ContentCacheOptions {
  std::string dir;        // Absolute; made if need be.
  int64_t max_bytes = 0;  // Content used longest ago gives way; never what was used in an hour.
};

// A job that waits for its content.
struct FetchContext {
  CancelToken cancel;
  std::function<void()> file_begins = [] {};  // Called before each file that is fetched.
};

// Thread-safe.
class ContentCache {
 public:
  explicit ContentCache(ContentCacheOptions options) : options_(std::move(options)) {}

  // The folder that `name`, a folder of a config, stands for on this machine, as BelowPictureRoot
  // takes it: a name that is no reference, or whose content lies below the picture root, is the
  // path below that; else the content is brought into the cache. A list that the store has not is
  // no error: the path is taken at its word, and whoever reads it compares hashes. Errors: the
  // store's and the disk's; kDataLoss for a file that is not what its hash says; kInvalidArgument
  // for a list that is none; kResourceExhausted for content larger than the cache; kCancelled.
  absl::StatusOr<std::string> Bring(const Store& store, const std::string& name,
                                    const FetchContext& context) const;

 private:
  absl::StatusOr<std::vector<ContentFile>> ListOf(const Store& store, const std::string& sha256,
                                                  const std::string& kept) const;
  absl::Status Fetch(const Store& store, const std::vector<ContentFile>& files,
                     const std::string& dir, const FetchContext& context) const;
  absl::Status MakeRoom(int64_t bytes, const std::string& keep) const;

  const ContentCacheOptions options_;
};

// Puts the folders that the job's config or the job itself names in their places here.
// Errors: those of Bring.
absl::Status BringContent(const ContentCache& cache, const Store& store,
                          const FetchContext& context, v1::SolveJob& job);
absl::Status BringContent(const ContentCache& cache, const Store& store,
                          const FetchContext& context, v1::RenderJob& job);

}  // namespace parallax
