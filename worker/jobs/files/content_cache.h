// The user's own content (common/store/content.h) on this machine: below the picture root, where
// the operator has put it, or in a cache, into which it is fetched from the store once. Several
// workers may share a cache. Each file is checked by its hash before it is used.
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
  // Called before each piece that is fetched, and while another job's fetch is waited for.
  std::function<void()> progress = [] {};
};

// Thread-safe.
class ContentCache {
 public:
  explicit ContentCache(ContentCacheOptions options) : options_(std::move(options)) {}

  // Returns the path of a config's folder `name` on this machine, in the form that BelowPictureRoot
  // takes. If `name` is no reference to content, or the same content lies below the picture root,
  // this is the path below that root. Otherwise the content is fetched into the cache, and the path
  // is absolute. If the store has no list for the reference, the path below the picture root is
  // returned unchecked, because its readers compare hashes.
  // Errors: the store's and the disk's; kDataLoss for a file that is not what its hash says;
  // kInvalidArgument for a list that is none; kResourceExhausted for content larger than the cache;
  // kCancelled.
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

// Brings all folders that the job names, and replaces their names in the job by paths on this
// machine.
// Errors: those of Bring.
absl::Status BringContent(const ContentCache& cache, const Store& store,
                          const FetchContext& context, v1::SolveJob& job);
absl::Status BringContent(const ContentCache& cache, const Store& store,
                          const FetchContext& context, v1::RenderJob& job);

}  // namespace parallax
