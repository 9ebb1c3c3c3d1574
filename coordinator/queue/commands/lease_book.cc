#include "coordinator/queue/commands/lease_book.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "common/base/seconds.h"

namespace parallax {
namespace {

constexpr size_t kMostLiveLogBytes = 4096;  // Each lease keeps the last ones.

}  // namespace

void LeaseBook::Add(const LeaseRef& lease, double unheard_s) {
  const std::lock_guard lock(mutex_);
  const auto known = entries_.find(lease.job);
  if (known != entries_.end()) EraseLocked(known);
  entries_[lease.job] = {lease, SecondsAfter(clock_.Steady(), -unheard_s), {}};
  ++held_by_[lease.worker];
}

void LeaseBook::Remove(const LeaseRef& lease) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(lease.job);
  if (found != entries_.end() && found->second.lease.fence == lease.fence) EraseLocked(found);
}

void LeaseBook::EraseLocked(std::map<int64_t, Entry>::iterator entry) {
  const auto held = held_by_.find(entry->second.lease.worker);
  if (held != held_by_.end() && --held->second <= 0) held_by_.erase(held);
  entries_.erase(entry);
}

int LeaseBook::HeldBy(const std::string& worker) const {
  const std::lock_guard lock(mutex_);
  const auto found = held_by_.find(worker);
  return found == held_by_.end() ? 0 : found->second;
}

LeaseBook::Entry* LeaseBook::FindLocked(const std::string& worker, const v1::AttemptId& attempt) {
  const auto found = entries_.find(attempt.job_id());
  if (found == entries_.end()) return nullptr;
  const LeaseRef& lease = found->second.lease;
  return lease.fence == attempt.fence() && lease.worker == worker ? &found->second : nullptr;
}

bool LeaseBook::Touch(const std::string& worker, const v1::AttemptId& attempt) {
  const std::lock_guard lock(mutex_);
  Entry* entry = FindLocked(worker, attempt);
  if (entry != nullptr) entry->heard = clock_.Steady();
  return entry != nullptr;
}

std::vector<v1::AttemptId> LeaseBook::Heartbeat(const std::string& worker,
                                                const std::vector<v1::Progress>& running) {
  const std::lock_guard lock(mutex_);
  const SteadyTime now = clock_.Steady();
  std::vector<v1::AttemptId> strangers;
  for (const v1::Progress& progress : running) {
    if (Entry* entry = FindLocked(worker, progress.attempt())) {
      entry->heard = now;
      entry->progress = {progress.fraction(), progress.stage(), {}, {}};
      if (progress.log_tail().size() <= kMostLiveLogBytes) {
        entry->progress.log_tail = progress.log_tail();
      }
      for (const auto& [name, value] : progress.figures()) {
        // A loss that is none is no reason to lose the worker, and no number for a page.
        if (std::isfinite(value)) entry->progress.figures[name] = value;
      }
    } else {
      strangers.push_back(progress.attempt());
    }
  }
  return strangers;
}

double LeaseBook::Age(const Entry& entry) const {
  return SecondsBetween(entry.heard, clock_.Steady());
}

std::vector<LeaseRef> LeaseBook::Expired() const {
  const std::lock_guard lock(mutex_);
  std::vector<LeaseRef> expired;
  for (const auto& [job, entry] : entries_) {
    if (Age(entry) >= lease_s_) expired.push_back(entry.lease);
  }
  return expired;
}

double LeaseBook::SecondsToExpiry() const {
  const std::lock_guard lock(mutex_);
  double seconds = lease_s_;
  for (const auto& [job, entry] : entries_) seconds = std::min(seconds, lease_s_ - Age(entry));
  return std::max(0.0, seconds);
}

bool LeaseBook::Holds(const std::string& worker, const v1::AttemptId& attempt) const {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(attempt.job_id());
  return found != entries_.end() && found->second.lease.fence == attempt.fence() &&
         found->second.lease.worker == worker;
}

LeaseProgress LeaseBook::ProgressOf(int64_t job) const {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(job);
  return found == entries_.end() ? LeaseProgress() : found->second.progress;
}

std::map<int64_t, std::map<std::string, double>> LeaseBook::Figures(size_t most) const {
  const std::lock_guard lock(mutex_);
  std::map<int64_t, std::map<std::string, double>> figures;
  for (const auto& [job, entry] : entries_) {
    if (figures.size() == most) break;
    if (!entry.progress.figures.empty()) figures[job] = entry.progress.figures;
  }
  return figures;
}

int64_t LeaseBook::size() const {
  const std::lock_guard lock(mutex_);
  return static_cast<int64_t>(entries_.size());
}

}  // namespace parallax
