#include "coordinator/rpc/task_pool.h"

#include <pthread.h>

namespace parallax {

void TaskPool::Start() {
  for (std::thread& thread : threads_) thread = std::thread([this] { Loop(); });
}

TaskPool::~TaskPool() {
  {
    std::lock_guard lock(mu_);
    closing_ = true;
  }
  work_.notify_all();
  for (std::thread& thread : threads_) {
    if (thread.joinable()) thread.join();
  }
}

void TaskPool::Run(std::function<void()> task) {
  {
    std::lock_guard lock(mu_);
    tasks_.push_back(std::move(task));
  }
  work_.notify_one();
}

bool TaskPool::RunNext() {
  std::function<void()> task;
  {
    std::lock_guard lock(mu_);
    if (tasks_.empty()) return false;
    task = std::move(tasks_.front());
    tasks_.pop_front();
  }
  task();
  return true;
}

void TaskPool::Loop() {
  pthread_setname_np(pthread_self(), "rpc-pool");
  while (true) {
    std::function<void()> task;
    {
      std::unique_lock lock(mu_);
      work_.wait(lock, [this] { return closing_ || !tasks_.empty(); });
      if (tasks_.empty()) return;
      task = std::move(tasks_.front());
      tasks_.pop_front();
    }
    task();
  }
}

}  // namespace parallax
