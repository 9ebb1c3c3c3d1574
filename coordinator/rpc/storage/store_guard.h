// Watches whether the store is there, under its name and with its id, while a coordinator serves: a
// disk may be unmounted or swapped at any time.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "common/base/status.h"
#include "common/store/store.h"

namespace parallax {

// Thread-safe. Has one thread.
class StoreGuard {
 public:
  // Looks every `every_s` seconds and calls `changed` from its thread whenever the store has gone
  // (with the reason) or is back (OK). `store` must outlive the guard.
  StoreGuard(const Store& store, double every_s, std::function<void(const absl::Status&)> changed);
  ~StoreGuard();
  StoreGuard(const StoreGuard&) = delete;
  StoreGuard& operator=(const StoreGuard&) = delete;

  // Return OK while the store is there, as of the last look or of one now. Errors: kUnavailable
  // with the reason.
  absl::Status status() const;
  absl::Status Look();

 private:
  void Loop();

  const Store& store_;
  const double every_s_;
  const std::function<void(const absl::Status&)> changed_;
  std::mutex looking_;  // Held by one look at a time; taken before mu_.
  mutable std::mutex mu_;
  std::condition_variable stop_;
  // Guarded by mu_.
  absl::Status status_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace parallax
