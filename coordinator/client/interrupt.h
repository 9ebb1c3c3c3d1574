// Turns Ctrl-C and SIGTERM into events to wait for, so that they don't end the process in the
// middle of its work.
//
// Only one InterruptScope may live at a time, and only one thread may wait.
#pragma once

#include <chrono>

namespace parallax::client {

class InterruptScope {
 public:
  InterruptScope();   // Starts to count SIGINT and SIGTERM, and to ignore SIGPIPE.
  ~InterruptScope();  // Restores the former handlers.
  InterruptScope(const InterruptScope&) = delete;
  InterruptScope& operator=(const InterruptScope&) = delete;

  // Returns the number of signals so far.
  int count() const;
  // Waits for a signal that no earlier wait has returned for. Returns true for a signal, false if
  // `time` is over.
  bool WaitFor(std::chrono::duration<double> time);

 private:
  int answered_ = 0;
};

}  // namespace parallax::client
