// A flag by which one thread asks work on other threads to stop. Copies share the flag, which is
// never cleared. Long work polls it between steps. Thread-safe.
#pragma once

#include <atomic>
#include <memory>

namespace parallax {

class CancelToken {
 public:
  CancelToken() : flag_(std::make_shared<std::atomic<bool>>(false)) {}
  void Cancel() const { flag_->store(true, std::memory_order_relaxed); }
  bool cancelled() const { return flag_->load(std::memory_order_relaxed); }

 private:
  std::shared_ptr<std::atomic<bool>> flag_;
};

}  // namespace parallax
