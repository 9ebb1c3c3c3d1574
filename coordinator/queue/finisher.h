// Runs what may take its time after a commit on a thread of its own, so that the writer doesn't
// wait for it.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace parallax {

// Thread-safe.
class Finisher {
 public:
  // Answers to workers that ask for leases come first: who asks is idle, who reports is at its next
  // job already.
  enum class Turn { kFirst, kAfterThose };

  Finisher() : thread_([this] { Loop(); }) {}
  ~Finisher();  // Runs what was accepted.

  // Tasks of one turn run in the order of their calls.
  void Enqueue(Turn turn, std::function<void()> task);

 private:
  void Loop();

  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> first_, after_those_;  // Guarded by mutex_.
  bool stopping_ = false;                                  // Guarded by mutex_.
  std::thread thread_;
};

}  // namespace parallax
