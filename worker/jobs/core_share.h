// Keeps jobs that compute with threads of their own (trainings, predictions) from running beside
// others on the same cores.
//
// A folder holds a lock file for each core and one for the queue before them. A training locks as
// many cores as it has threads; jobs whose threads are shared by the whole worker lock one together
// with others of their kind. So trainings never share cores, and rendering waits where they take
// all. Locks are the kernel's: they end with their process. Workers that are given the same folder
// share it.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"

namespace parallax {

class CoreShare {
 public:
  // `cores` must be the same for all who use `dir`.
  CoreShare(std::string dir, int cores) : dir_(std::move(dir)), cores_(cores) {}

  // Locks until it is destroyed.
  class Hold {
   public:
    Hold() = default;
    ~Hold();
    Hold(Hold&& other) noexcept : files_(std::move(other.files_)) { other.files_.clear(); }
    Hold& operator=(Hold&& other) noexcept {
      std::swap(files_, other.files_);
      return *this;
    }

   private:
    friend class CoreShare;
    std::vector<int> files_;  // Descriptors.
  };

  using Waiting = std::function<void()>;  // Called many times a second while it waits.

  // Waits until `threads` cores (at most all) are free, and has them alone. Errors: kCancelled;
  // those of the folder.
  absl::StatusOr<Hold> TakeAlone(int threads, const CancelToken& cancel,
                                 const Waiting& waiting) const;
  // Waits for a core that nobody has alone. Errors: as TakeAlone.
  absl::StatusOr<Hold> TakeShared(const CancelToken& cancel, const Waiting& waiting) const;

 private:
  absl::StatusOr<Hold> Take(int count, int operation, const CancelToken& cancel,
                            const Waiting& waiting) const;

  const std::string dir_;
  const int cores_;
};

}  // namespace parallax
