// Ends calls that keep still. A synchronous handler holds a thread while it waits for its peer; it
// announces here until when it will wait, and is cancelled after that, which ends its Read or
// Write.
//
// Thread-safe.
#pragma once

#include <condition_variable>
#include <functional>
#include <list>
#include <mutex>
#include <thread>

#include "common/base/clock.h"

namespace parallax {

class CallWatch {
 private:
  struct Entry {
    std::function<void()> cancel;
    SteadyTime deadline;
    bool expired = false;
  };

 public:
  CallWatch();
  ~CallWatch();
  CallWatch(const CallWatch&) = delete;
  CallWatch& operator=(const CallWatch&) = delete;

  // One call under watch, from construction to destruction. `cancel` runs on the watch's thread, at
  // most once, never after the destructor has returned, and must not block.
  class Call {
   public:
    Call(CallWatch& watch, std::function<void()> cancel, double seconds);
    ~Call();
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

    // The call has moved on: it is watched for `seconds` from now.
    void Extend(double seconds);
    // Cancels it now, as if its time were over.
    void Expire();
    // It was cancelled by the watch.
    bool expired() const;

   private:
    CallWatch& watch_;
    std::list<Entry>::iterator entry_;
  };

 private:
  void Loop();

  mutable std::mutex mu_;
  std::condition_variable changed_;
  // Guarded by mu_.
  std::list<Entry> entries_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace parallax
