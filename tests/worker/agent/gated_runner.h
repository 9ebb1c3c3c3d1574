#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

#include "common/base/status.h"
#include "noop_runner.h"

namespace parallax {

// Holds every solve until released or cancelled.
class GatedRunner final : public NoopRunner {
 public:
  absl::StatusOr<v1::SolveResult> Solve(const v1::SolveJob& job, const CancelToken& cancel,
                                        const JobProgressFn& progress) override {
    std::unique_lock lock(mu_);
    ++started_;
    changed_.notify_all();
    while (!changed_.wait_for(lock, std::chrono::milliseconds(2), [this] { return released_; })) {
      if (!cancel.cancelled()) continue;
      ++cancelled_;
      changed_.notify_all();
      return Cancelled("told to");
    }
    lock.unlock();
    return NoopRunner::Solve(job, cancel, progress);
  }
  void Release() {
    std::lock_guard lock(mu_);
    released_ = true;
    changed_.notify_all();
  }
  bool WaitForStart() {
    std::unique_lock lock(mu_);
    return changed_.wait_for(lock, std::chrono::seconds(20), [this] { return started_ > 0; });
  }
  bool WaitForCancel() {
    std::unique_lock lock(mu_);
    return changed_.wait_for(lock, std::chrono::seconds(20), [this] { return cancelled_ > 0; });
  }
  int started() {
    std::lock_guard lock(mu_);
    return started_;
  }

 private:
  std::mutex mu_;
  std::condition_variable changed_;
  int started_ = 0;
  int cancelled_ = 0;
  bool released_ = false;
};

}  // namespace parallax
