// Keeps jobs with threads of their own (trainings, predictions) from sharing cores with others.
//
// A folder holds a lock file for each core and one for the queue before them. A training locks as
// many cores as it has threads; jobs that use the worker's shared threads lock one core together.
// Thus trainings never share cores, and rendering waits while they use all. The locks are the
// kernel's and end with their process. Workers with the same folder share them.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/base/cancel.h"
#include "common/base/status.h"

namespace parallax {

// The cores of one machine.
class CoreShare {
 public:
  // `cores` must be equal for all users of `dir`.
  CoreShare(std::string dir, int cores) : dir_(std::move(dir)), cores_(cores) {}

  // Holds locks until it is destroyed.
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

  using Waiting = std::function<void()>;  // Called many times a second during a wait.

  // Waits for `threads` free cores (at most all), and locks them exclusively. Errors: kCancelled;
  // those of the folder.
  absl::StatusOr<Hold> TakeAlone(int threads, const CancelToken& cancel,
                                 const Waiting& waiting) const;
  // Waits for a core without an exclusive lock. Errors: as TakeAlone.
  absl::StatusOr<Hold> TakeShared(const CancelToken& cancel, const Waiting& waiting) const;

 private:
  absl::StatusOr<Hold> Take(int count, int operation, const CancelToken& cancel,
                            const Waiting& waiting) const;

  const std::string dir_;
  const int cores_;
};

}  // namespace parallax
