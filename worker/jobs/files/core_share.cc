#include "worker/jobs/files/core_share.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <thread>

#include "common/base/system/file.h"
#include "worker/jobs/files/store_files.h"

namespace parallax {
namespace {

constexpr std::chrono::milliseconds kPause(50);

absl::StatusOr<int> OpenLock(const std::string& path) {
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (file < 0) return ErrnoError(errno, "open " + path);
  return file;
}

}  // namespace

CoreShare::Hold::~Hold() {
  for (const int file : files_) close(file);
}

absl::StatusOr<CoreShare::Hold> CoreShare::TakeAlone(int threads, const CancelToken& cancel,
                                                     const Waiting& waiting) const {
  return Take(std::clamp(threads, 1, cores_), LOCK_EX, cancel, waiting);
}

absl::StatusOr<CoreShare::Hold> CoreShare::TakeShared(const CancelToken& cancel,
                                                      const Waiting& waiting) const {
  return Take(1, LOCK_SH, cancel, waiting);
}

// The first in the queue takes cores as they become free; so many small jobs can't keep out one
// that needs all.
absl::StatusOr<CoreShare::Hold> CoreShare::Take(int count, int operation, const CancelToken& cancel,
                                                const Waiting& waiting) const {
  RETURN_IF_ERROR(MakeFolders(dir_));
  Hold queue, held, others;
  ASSIGN_OR_RETURN(const int gate, OpenLock(dir_ + "/queue"));
  queue.files_.push_back(gate);
  std::vector<int> left;
  for (int core = 0; core < cores_; ++core) {
    ASSIGN_OR_RETURN(const int file, OpenLock(fmt::format("{}/core-{}", dir_, core)));
    others.files_.push_back(file);
    left.push_back(file);
  }
  bool is_first = false;
  while (!cancel.cancelled()) {
    is_first = is_first || flock(gate, LOCK_EX | LOCK_NB) == 0;
    for (size_t i = 0; is_first && i < left.size();) {
      if (flock(left[i], operation | LOCK_NB) != 0) {
        ++i;
        continue;
      }
      held.files_.push_back(left[i]);
      std::erase(others.files_, left[i]);
      left.erase(left.begin() + static_cast<ptrdiff_t>(i));
      if (static_cast<int>(held.files_.size()) == count) return held;
    }
    waiting();
    std::this_thread::sleep_for(kPause);
  }
  return Cancelled("while it waited for cores");
}

}  // namespace parallax
