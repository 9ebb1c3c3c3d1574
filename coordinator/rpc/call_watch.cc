#include "coordinator/rpc/call_watch.h"

#include <pthread.h>

#include "common/base/seconds.h"

namespace parallax {
namespace {

// Largest delay of ending a call.
constexpr double kLookEvery_s = 0.25;

SteadyTime Now() { return Clock::System().Steady(); }

}  // namespace

CallWatch::CallWatch() : thread_([this] { Loop(); }) {}

CallWatch::~CallWatch() {
  {
    const std::lock_guard lock(mu_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void CallWatch::Loop() {
  pthread_setname_np(pthread_self(), "call-watch");
  std::unique_lock lock(mu_);
  while (!stopping_) {
    const SteadyTime now = Now();
    for (Entry& entry : entries_) {
      if (entry.expired || now < entry.deadline) continue;
      entry.expired = true;
      entry.cancel();
    }
    if (entries_.empty()) {
      changed_.wait(lock, [this] { return stopping_ || !entries_.empty(); });
    } else {
      changed_.wait_for(lock, std::chrono::duration<double>(kLookEvery_s),
                        [this] { return stopping_; });
    }
  }
}

CallWatch::Call::Call(CallWatch& watch, std::function<void()> cancel, double seconds)
    : watch_(watch) {
  const std::lock_guard lock(watch_.mu_);
  watch_.entries_.push_back({std::move(cancel), SecondsAfter(Now(), seconds)});
  entry_ = std::prev(watch_.entries_.end());
  watch_.changed_.notify_all();
}

CallWatch::Call::~Call() {
  const std::lock_guard lock(watch_.mu_);
  watch_.entries_.erase(entry_);
}

void CallWatch::Call::Extend(double seconds) {
  const std::lock_guard lock(watch_.mu_);
  entry_->deadline = SecondsAfter(Now(), seconds);
}

void CallWatch::Call::Expire() {
  const std::lock_guard lock(watch_.mu_);
  if (entry_->expired) return;
  entry_->expired = true;
  entry_->cancel();
}

bool CallWatch::Call::expired() const {
  const std::lock_guard lock(watch_.mu_);
  return entry_->expired;
}

}  // namespace parallax
