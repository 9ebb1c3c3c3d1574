#include "common/store/store_guard.h"

#include <chrono>

#include "common/base/system/log.h"

namespace parallax {
namespace {

// Whether it is certain that the store is not there.
bool IsCertain(const absl::Status& status) {
  return !absl::IsUnavailable(status) && !absl::IsDeadlineExceeded(status) &&
         !absl::IsResourceExhausted(status);
}

}  // namespace

StoreGuard::StoreGuard(const Store& store, Options options)
    : store_(store), options_(std::move(options)) {
  thread_ = std::thread([this] { Loop(); });
}

StoreGuard::~StoreGuard() {
  {
    const std::lock_guard lock(mu_);
    stopping_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void StoreGuard::LookSoon() {
  {
    const std::lock_guard lock(mu_);
    hurries_ = true;
  }
  wake_.notify_all();
}

absl::Status StoreGuard::status() const {
  const std::lock_guard lock(mu_);
  return status_;
}

absl::Status StoreGuard::Look() {
  const std::lock_guard looking(looking_);
  const absl::Status seen = store_.CheckMarker();
  const absl::Status before = status();
  if (!seen.ok() && options_.patient && !IsCertain(seen)) return before;
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
    LogError("no work until the store is back", {{"error", now}});
  }
  options_.changed(now);
  return now;
}

void StoreGuard::Loop() {
  std::unique_lock lock(mu_);
  while (!stopping_) {
    hurries_ = false;
    lock.unlock();
    Look().IgnoreError();
    lock.lock();
    wake_.wait_for(lock, std::chrono::duration<double>(options_.every_s),
                   [this] { return stopping_ || hurries_; });
  }
}

}  // namespace parallax
