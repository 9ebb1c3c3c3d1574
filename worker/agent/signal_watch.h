// Turns SIGTERM, SIGINT, SIGUSR1 and the parent's death into calls on a thread of its own.
#pragma once

#include <functional>
#include <thread>

namespace parallax {

// Watches until it is destroyed.
class SignalWatch {
 public:
  struct Handlers {
    // `count`: 1 for the first SIGTERM or SIGINT, 2 for the second...
    std::function<void(int count)> on_signal;
    std::function<void()> on_long_drain;  // SIGUSR1. Null: ignored.
    std::function<void()> on_orphaned;    // The parent died. Null: not watched.
  };

  // Construct it before any other thread starts: it blocks the signals in the calling thread, and
  // later threads inherit that.
  explicit SignalWatch(Handlers handlers);
  ~SignalWatch();
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;

 private:
  void Loop(int signals, int parent) const;

  const Handlers handlers_;
  int stop_ = -1;
  std::thread thread_;
};

}  // namespace parallax
