#include "coordinator/queue/commands/finisher.h"

#include <pthread.h>

#include <utility>

namespace parallax {

Finisher::~Finisher() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void Finisher::Enqueue(Turn turn, std::function<void()> task) {
  if (!thread_.joinable()) return task();
  {
    const std::lock_guard lock(mutex_);
    (turn == Turn::kFirst ? first_ : after_those_).push_back(std::move(task));
  }
  wake_.notify_one();
}

void Finisher::Loop() {
  pthread_setname_np(pthread_self(), "queue-finisher");
  for (;;) {
    std::function<void()> task;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return stopping_ || !first_.empty() || !after_those_.empty(); });
      auto& tasks = first_.empty() ? after_those_ : first_;
      if (tasks.empty()) return;
      task = std::move(tasks.front());
      tasks.pop_front();
    }
    task();
  }
}

}  // namespace parallax
