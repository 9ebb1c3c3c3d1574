// Lets Ctrl-C end long work on this machine in an orderly way.
#pragma once

#include <atomic>
#include <chrono>
#include <thread>

#include "common/base/cancel.h"
#include "coordinator/client/interrupt.h"

namespace parallax::client {

// Makes Ctrl-C and SIGTERM cancel `token()` instead of ending the process, as long as the object
// exists. Only one may exist at a time.
class CancellableScope {
 public:
  CancellableScope()
      : watch_([this] {
          while (!ended_) {
            if (interrupt_.WaitFor(std::chrono::milliseconds(100))) token_.Cancel();
          }
        }) {}
  ~CancellableScope() {
    ended_ = true;
    watch_.join();
  }
  CancellableScope(const CancellableScope&) = delete;
  CancellableScope& operator=(const CancellableScope&) = delete;

  const CancelToken& token() const { return token_; }

 private:
  InterruptScope interrupt_;
  CancelToken token_;
  std::atomic<bool> ended_ = false;
  std::thread watch_;  // Last: it uses the others.
};

}  // namespace parallax::client
