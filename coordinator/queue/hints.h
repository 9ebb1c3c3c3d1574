// Upper bounds on counts in the hot tables, kept in memory to save queries that would find nothing:
// whether a group has READY or LEASED jobs, and whether any job waits for a given one. They only
// err towards "maybe": additions count at once, removals count when their group is committed, and
// an undone command leaves its additions behind.
//
// Used by the writing thread only.
#pragma once

#include <cstdint>
#include <cstring>
#include <unordered_map>
#include <vector>

#include "common/base/hash.h"
#include "coordinator/queue/job_state.h"

namespace parallax {

// Upper bounds on counts by key.
class SupersetCounter {
 public:
  void Add(uint64_t key) { ++counts_[key]; }
  void RemoveAtCommit(uint64_t key) { removed_.push_back(key); }
  // Returns an upper bound on the current count.
  int64_t AtMost(uint64_t key) const {
    const auto found = counts_.find(key);
    return found == counts_.end() ? 0 : found->second;
  }

  void BeginCommand() { mark_ = removed_.size(); }
  void UndoCommand() { removed_.resize(mark_); }
  void Committed() {
    for (const uint64_t key : removed_) {
      const auto found = counts_.find(key);
      if (found != counts_.end() && --found->second <= 0) counts_.erase(found);
    }
    removed_.clear();
    mark_ = 0;
  }
  void Clear() {
    counts_.clear();
    removed_.clear();
    mark_ = 0;
  }

 private:
  std::unordered_map<uint64_t, int64_t> counts_;
  std::vector<uint64_t> removed_;
  size_t mark_ = 0;
};

// The hints about jobs: the machine reports every job that enters or leaves a state.
class JobHints {
 public:
  void Entered(JobState state, const Sha256Digest& group_key, int64_t awaits_job) {
    if (state == JobState::kReady) ready_.Add(KeyOf(group_key));
    if (state == JobState::kLeased) leased_.Add(KeyOf(group_key));
    if (state == JobState::kBlocked && awaits_job != 0) {
      awaited_.Add(static_cast<uint64_t>(awaits_job));
    }
  }
  void Left(JobState state, const Sha256Digest& group_key, int64_t awaits_job) {
    if (state == JobState::kReady) ready_.RemoveAtCommit(KeyOf(group_key));
    if (state == JobState::kLeased) leased_.RemoveAtCommit(KeyOf(group_key));
    if (state == JobState::kBlocked && awaits_job != 0) {
      awaited_.RemoveAtCommit(static_cast<uint64_t>(awaits_job));
    }
  }

  int64_t ReadyIn(const Sha256Digest& group_key) const { return ready_.AtMost(KeyOf(group_key)); }
  int64_t LeasedIn(const Sha256Digest& group_key) const { return leased_.AtMost(KeyOf(group_key)); }
  int64_t WaitingFor(int64_t job) const { return awaited_.AtMost(static_cast<uint64_t>(job)); }

  void BeginCommand() {
    Each([](SupersetCounter& c) { c.BeginCommand(); });
  }
  void UndoCommand() {
    Each([](SupersetCounter& c) { c.UndoCommand(); });
  }
  void Committed() {
    Each([](SupersetCounter& c) { c.Committed(); });
  }
  void Clear() {
    Each([](SupersetCounter& c) { c.Clear(); });
  }

 private:
  // Returns a short key of a digest. Two groups may share a key, which only turns a "no" into a
  // "maybe".
  static uint64_t KeyOf(const Sha256Digest& digest) {
    uint64_t key;
    std::memcpy(&key, digest.data(), sizeof key);
    return key;
  }
  template <typename Function>
  void Each(const Function& function) {
    for (SupersetCounter* counter : {&ready_, &leased_, &awaited_}) function(*counter);
  }

  SupersetCounter ready_, leased_, awaited_;
};

}  // namespace parallax
