// Ctrl-C and SIGTERM as something to wait for, rather than something that ends the process in the
// middle.
//
// At most one InterruptScope lives at a time. Waiting is for one thread.
#pragma once

#include <chrono>

namespace parallax::client {

class InterruptScope {
 public:
  InterruptScope();   // From here on SIGINT and SIGTERM are counted, SIGPIPE is ignored.
  ~InterruptScope();  // The handlers of before.
  InterruptScope(const InterruptScope&) = delete;
  InterruptScope& operator=(const InterruptScope&) = delete;

  // Signals so far.
  int count() const;
  // Until the time is over or a signal comes that no wait has returned for yet; true for the
  // latter.
  bool WaitFor(std::chrono::duration<double> time);

 private:
  int answered_ = 0;
};

}  // namespace parallax::client
