#include "coordinator/rpc/storage/store_guard.h"

#include <chrono>

#include "common/base/system/log.h"

namespace parallax {
namespace {

// Whether it is certain that the store is not there: a server that does not answer for a moment is
// no other server.
bool IsCertain(const absl::Status& status) {
  return !absl::IsUnavailable(status) && !absl::IsDeadlineExceeded(status) &&
         !absl::IsResourceExhausted(status);
}

}  // namespace

StoreGuard::StoreGuard(const Store& store, double every_s,
                       std::function<void(const absl::Status&)> changed)
    : store_(store), every_s_(every_s), changed_(std::move(changed)) {
  thread_ = std::thread([this] { Loop(); });
}

StoreGuard::~StoreGuard() {
  {
    const std::lock_guard lock(mu_);
    stopping_ = true;
  }
  stop_.notify_all();
  thread_.join();
}

absl::Status StoreGuard::status() const {
  const std::lock_guard lock(mu_);
  return status_;
}

absl::Status StoreGuard::Look() {
  const std::lock_guard looking(looking_);
  const absl::Status seen = store_.CheckMarker();
  const absl::Status before = status();
  if (!seen.ok() && !IsCertain(seen)) return before;
  const absl::Status now =
      seen.ok() ? absl::OkStatus() : Unavailable("the store is gone: {}", ToStd(seen.message()));
  {
    const std::lock_guard lock(mu_);
    status_ = now;
  }
  if (now.ok() == before.ok()) return now;
  if (now.ok()) {
    LogInfo("the store is back; work goes on", {{"store", store_.Uri()}});
  } else {
    LogError("no leases until the store is back", {{"error", now}});
  }
  changed_(now);
  return now;
}

void StoreGuard::Loop() {
  std::unique_lock lock(mu_);
  while (!stopping_) {
    lock.unlock();
    Look().IgnoreError();
    lock.lock();
    stop_.wait_for(lock, std::chrono::duration<double>(every_s_), [this] { return stopping_; });
  }
}

}  // namespace parallax
