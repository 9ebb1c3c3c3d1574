// Ends calls without progress. A synchronous handler holds a thread while it waits for its peer. It
// announces here how long it will wait; after that time its call is cancelled, which ends its Read
// or Write.
//
// Thread-safe.
#pragma once

#include <condition_variable>
#include <functional>
#include <list>
#include <mutex>
#include <thread>

#include "common/base/system/clock.h"

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

  // One call under watch, from construction to destruction. `cancel` must not block. It runs on the
  // watch's thread, at most once, and never after the destructor has returned.
  class Call {
   public:
    Call(CallWatch& watch, std::function<void()> cancel, double seconds);
    ~Call();
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

    // Notes progress: the call may now wait for `seconds` from now.
    void Extend(double seconds);
    // Cancels the call now, as if its time were over.
    void Expire();
    // Returns whether the watch has cancelled the call.
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
