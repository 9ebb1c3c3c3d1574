// Watches whether the store is there, under its name and with its id, while a coordinator or worker
// runs: a disk may be unmounted or swapped at any time, and a look may hang.
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
  struct Options {
    double every_s = 2;  // Time between two looks.
    // A server that does not answer for a moment is no other server: status() stays as it is.
    bool patient = false;
    // Called from the guard's thread whenever the store has gone (with the reason) or is back (OK).
    std::function<void(const absl::Status&)> changed;
  };
  // The store counts as there until the first look. `store` must outlive the guard.
  StoreGuard(const Store& store, Options options);
  ~StoreGuard();  // Waits for a look under way.
  StoreGuard(const StoreGuard&) = delete;
  StoreGuard& operator=(const StoreGuard&) = delete;

  // Return OK while the store is there, as of the last look or of one now. Errors: kUnavailable
  // with the reason.
  absl::Status status() const;
  absl::Status Look();
  // Has the thread look at once.
  void LookSoon();

 private:
  void Loop();

  const Store& store_;
  const Options options_;
  std::mutex looking_;  // Held by one look at a time; taken before mu_.
  mutable std::mutex mu_;
  std::condition_variable wake_;
  // Guarded by mu_.
  absl::Status status_;
  bool stopping_ = false;
  bool hurries_ = false;
  std::thread thread_;
};

}  // namespace parallax
