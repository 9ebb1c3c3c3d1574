#include "coordinator/queue/commands/upkeep.h"

#include <algorithm>
#include <chrono>

namespace parallax {
namespace {

constexpr int kArchivedAtOnce = 500;  // Jobs in one tick: some milliseconds.
constexpr int kRemovedAtOnce = 200;   // Rows of forgotten studies, likewise.
constexpr std::chrono::seconds kRemoveEvery{60};

}  // namespace

absl::Status Upkeep::Tick() {
  RETURN_IF_ERROR(EndAllUntold());
  RETURN_IF_ERROR(machine_.reports().Expire(book_.Expired()));
  RETURN_IF_ERROR(machine_.retries().Wake());
  return RemovalIsDue() ? RemoveSome() : absl::OkStatus();
}

void Upkeep::EndUntold(const GrantedLease& lease, const absl::Status& why) {
  v1::FailRequest failure;
  failure.mutable_attempt()->set_job_id(lease.work.job.id);
  failure.mutable_attempt()->set_fence(lease.fence);
  failure.set_worker(lease.worker);
  failure.set_retryable(true);
  failure.set_error("its worker can't be told what to do: " + std::string(why.message()));
  const std::lock_guard lock(mutex_);
  untold_.push_back({std::move(failure), absl::IsUnavailable(why)});
}

absl::Status Upkeep::EndAllUntold() {
  std::vector<Untold> untold;
  {
    const std::lock_guard lock(mutex_);
    // Only what is on disk is done: a group may be rolled back, or applied once more.
    std::erase_if(untold_, [this](const Untold& one) {
      return !book_.Holds(one.failure.worker(), one.failure.attempt());
    });
    untold = untold_;
  }
  Reports& reports = machine_.reports();
  for (const auto& [failure, is_of_disk] : untold) {
    RETURN_IF_ERROR((is_of_disk
                         ? reports.HandBack(failure.worker(), failure.attempt(), failure.error())
                         : reports.Fail(failure))
                        .status());
  }
  return absl::OkStatus();
}

absl::Status Upkeep::RemoveSome() {
  ASSIGN_OR_RETURN(bool more, machine_.forgetting().RemoveSome(kRemovedAtOnce));
  if (!more) {
    ASSIGN_OR_RETURN(more, machine_.forgetting().Archive(kArchivedAtOnce));
  }
  if (!more) remove_at_ = options_.clock->Steady() + kRemoveEvery;
  return absl::OkStatus();
}

bool Upkeep::IsDue() const {
  if (RemovalIsDue()) return true;
  {
    const std::lock_guard lock(mutex_);
    if (!untold_.empty()) return true;
  }
  const auto next = machine_.tables().jobs.NextBackoff();
  return next.ok() && SecondsToNext(*next) <= 0;
}

double Upkeep::SecondsToNext(const std::optional<double>& next_backoff) const {
  const double seconds = book_.SecondsToExpiry();
  if (!next_backoff) return seconds;
  const double wait = *next_backoff - options_.clock->UnixSeconds();
  // Further away than any back-off: the clock was set back.
  return std::min(seconds, wait > options_.retry.backoff_max_s ? 0 : std::max(0.0, wait));
}

}  // namespace parallax
