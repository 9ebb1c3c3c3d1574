// A coordinator's life without its network: a queue in a child process, driven by clients that
// write down each answer they were given in memory that outlives the child. Whatever ends it, the
// parent then holds the next start to those answers.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <set>
#include <string>

#include "tests/coordinator/queue/queue_fixture.h"
#include "tests/faults/experiment.h"

namespace parallax::faults {

struct Ack {
  enum Kind : int32_t {
    kStudy,      // study
    kCancelled,  // study
    kLeased,     // worker holds job, fence
    kCompleted,
    kFailed,
    kHandedBack,
    kMayEnd,     // A call begins that may end job, fence; with job 0: any lease
    kGone,       // And has returned
    kViolation,  // A client saw what it must never see.
  };
  Kind kind;
  int32_t client;
  int64_t study;
  int64_t job;
  uint64_t fence;
  char worker[16];
};

// Written by the child, read by the parent. Thread-safe.
class AckLog {
 public:
  AckLog();
  ~AckLog();
  AckLog(const AckLog&) = delete;
  AckLog& operator=(const AckLog&) = delete;
  void Add(const Ack& ack);
  size_t size() const;
  // The writer may have died between taking its place and filling it.
  bool IsWhole(size_t i) const { return shared_->whole[i].load(); }
  const Ack& operator[](size_t i) const { return shared_->acks[i]; }

 private:
  static constexpr size_t kCapacity = 1 << 16;
  struct Shared {
    std::atomic<size_t> next;
    std::atomic<bool> whole[kCapacity];
    Ack acks[kCapacity];
  };
  Shared* shared_;
};

// The kinds of jobs of a life: each study's noop jobs wait for its pairs and for each other.
const KindRegistry& Kinds();
// A worker of a life, and its report on a job.
WorkerFacts LivingWorker(const std::string& name);
v1::CompleteRequest AnswerOf(const v1::Lease& lease, const std::string& worker);

struct LifeOptions {
  JobQueueOptions queue;  // With db_path, vfs, fail_point, unsafe_for_test.
  FakeClock* clock = nullptr;
  int steps = 40;   // Calls of each client.
  int clients = 1;  // At the same time; with one, a life is the same for the same stream.
  // With one client: its life ends with each command that is seldom drawn.
  bool rare_commands = false;
};

// To be called in a child. Returns when all steps are done.
void Live(const LifeOptions& options, Rng rng, AckLog& acks);

// Checks what must be true after a restart, and remembers it through all lives of one database.
class Witness {
 public:
  Witness(const LifeOptions& options, Tally& tally) : options_(options), tally_(tally) {}

  // Opens the queue as the next start would, after a life with these acks: everything acknowledged
  // is there, the auditor is content. Leases still held are handed back.
  void Verify(const AckLog& acks);
  // Works everything off: each study that isn't cancelled has all its pairs, each once.
  void Finish();

 private:
  void NoteFence(uint64_t fence);
  void VerifyStudies(JobQueue& queue);
  void VerifyReports(JobQueue& queue);
  void VerifyLeases(JobQueue& queue);
  std::unique_ptr<JobQueue> Open();
  void Audit(JobQueue& queue, const std::string& where);
  void CountPairs(JobQueue& queue, int64_t study);

  LifeOptions options_;
  Tally& tally_;
  std::set<int64_t> studies_;
  std::set<int64_t> cancelled_;
  std::set<uint64_t> fences_;
  std::map<std::pair<int64_t, uint64_t>, Ack> reports_;
  std::map<std::pair<int64_t, uint64_t>, std::string> held_;
};

}  // namespace parallax::faults
