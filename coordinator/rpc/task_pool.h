// A pool of threads for calls that block (commits, reads), so that gRPC's own threads never block.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace parallax {

// Thread-safe.
class TaskPool {
 public:
  explicit TaskPool(int threads) : threads_(static_cast<size_t>(threads)) {}
  ~TaskPool();  // Runs all accepted tasks, then ends.

  // Starts the threads. Call it once, when all objects that tasks use exist; tasks that were
  // accepted earlier wait for it.
  void Start();
  // Accepts a task; a thread will run it.
  void Run(std::function<void()> task);
  // Runs the oldest task on the caller's thread, for a pool without threads. Returns false if there
  // is none.
  bool RunNext();

 private:
  void Loop();

  std::mutex mu_;
  std::condition_variable work_;
  std::deque<std::function<void()>> tasks_;  // Guarded by mu_.
  bool closing_ = false;                     // Guarded by mu_.
  std::vector<std::thread> threads_;
};

}  // namespace parallax
