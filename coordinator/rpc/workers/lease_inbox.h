// Messages from the queue's threads to the dispatcher's thread: answers to calls for leases, orders
// to stop attempts, and news that work may be ready.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "coordinator/rpc/workers/worker_link.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

// The abilities that make workers equal: kinds of jobs, memory, tags.
using WorkerClass = std::tuple<std::vector<std::string>, int64_t, std::vector<std::string>>;

// One message to the dispatcher's thread.
struct LeaseNote {
  enum Kind { kLeases, kStop } kind = kLeases;
  std::string worker;
  // For kLeases: the question and the answer.
  std::weak_ptr<WorkerLink> link;  // The worker's link at the time of the question.
  WorkerClass of_class;
  uint64_t round = 0;
  int asked = 0;
  absl::StatusOr<std::vector<v1::Lease>> leases = std::vector<v1::Lease>();
  // For kStop.
  v1::AttemptId attempt;
  std::string reason;
};

// The queue of notes. Thread-safe. The dispatcher and the pending calls share it, so that the last
// of them destroys it.
class LeaseInbox {
 public:
  // Leaves a note for Take.
  void Leave(LeaseNote note) {
    std::lock_guard lock(mu_);
    notes_.push_back(std::move(note));
    changed_.notify_one();
  }
  // Notes that work may be ready.
  void WorkIsReady() {
    std::lock_guard lock(mu_);
    work_ready_ = true;
    changed_.notify_one();
  }
  // Makes a waiting Take return without a note.
  void Poke() {
    std::lock_guard lock(mu_);
    poked_ = true;
    changed_.notify_one();
  }
  // Count the pending calls to the queue. CallEnds also leaves the call's answer as a note.
  void CallBegins() {
    std::lock_guard lock(mu_);
    ++calls_in_flight_;
  }
  void CallEnds(LeaseNote answer) {
    std::lock_guard lock(mu_);
    --calls_in_flight_;
    notes_.push_back(std::move(answer));
    changed_.notify_one();
  }

  // Waits until there is a note, work may be ready, Poke is called or the deadline passes. Takes
  // all notes. Returns whether work may be ready.
  bool Take(SteadyTime deadline, std::deque<LeaseNote>* notes) {
    std::unique_lock lock(mu_);
    // A wait for nothing costs a call of the system.
    if (deadline > SteadyTime()) {
      changed_.wait_until(lock, deadline,
                          [this] { return !notes_.empty() || work_ready_ || poked_; });
    }
    notes->swap(notes_);
    poked_ = false;
    return std::exchange(work_ready_, false);
  }
  // Returns whether no call is pending and no note is left.
  bool IsQuiet() {
    std::lock_guard lock(mu_);
    return calls_in_flight_ == 0 && notes_.empty();
  }

 private:
  std::mutex mu_;
  std::condition_variable changed_;
  // Guarded by mu_.
  std::deque<LeaseNote> notes_;
  bool work_ready_ = false;
  bool poked_ = false;
  int calls_in_flight_ = 0;
};

}  // namespace parallax
