// Runs the work that follows a commit on its own thread, so that the writer does not wait for it.
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
  // Order of tasks. Answers to workers that ask for leases come first, because those workers are
  // idle, whereas a worker that reports is already at its next job.
  enum class Turn { kFirst, kAfterThose };

  // Without a thread of its own, tasks run in Enqueue.
  explicit Finisher(bool own_thread) {
    if (own_thread) thread_ = std::thread([this] { Loop(); });
  }
  ~Finisher();  // Runs all accepted tasks.

  // Accepts a task. Tasks of one turn run in the order in which they were accepted.
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
