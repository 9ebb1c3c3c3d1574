#include "worker/agent/attempts/attempt_folders.h"

#include <fmt/core.h>

#include "common/base/system/log.h"
#include "common/rpc/remote_store.h"

namespace parallax {

AttemptFolders::AttemptFolders(Options options, std::shared_ptr<grpc::Channel> channel)
    : options_(std::move(options)), channel_(std::move(channel)) {}

absl::Status AttemptFolders::Use(const v1::Welcome& welcome) {
  const bool by_hand = !options_.store_uri.empty();
  const std::string& uri = by_hand ? options_.store_uri : welcome.store_uri();
  const std::string key =
      fmt::format("{} {} {}", uri, welcome.store_id(), static_cast<int>(welcome.store_access()));
  if (key == key_) return absl::OkStatus();
  std::shared_ptr<Store> store;
  if (by_hand || welcome.store_access() != v1::STORE_ACCESS_STREAM) {
    auto opened = OpenStore(uri, {.create = welcome.store_id().empty(), .id = welcome.store_id()});
    if (!opened.ok() && (by_hand || welcome.store_access() != v1::STORE_ACCESS_AUTO)) {
      return WithContext(opened.status(), "store " + uri + " can't be used from this machine");
    }
    if (opened.ok()) {
      store = *std::move(opened);
    } else {
      LogInfo("the store is not seen from here; files go through the coordinator",
              {{"store", uri}, {"cause", opened.status()}});
    }
  }
  guard_.reset();
  store_ = std::move(store);
  if (store_ != nullptr) {
    guard_ = std::make_unique<StoreGuard>(
        *store_,
        StoreGuard::Options{.every_s = options_.store_look_s,
                            .changed = [this](const absl::Status&) { options_.store_changed(); }});
  }
  key_ = key;
  return absl::OkStatus();
}

AttemptFolder AttemptFolders::ReadOnly(const v1::Lease& lease) const {
  AttemptFolder folder;
  folder.store = store_;
  if (store_ == nullptr) {
    folder.store = MakeRemoteStore(channel_, {options_.worker, lease.attempt()});
  }
  return folder;
}

absl::StatusOr<AttemptFolder> AttemptFolders::Of(const v1::Lease& lease) const {
  if (key_.empty()) return FailedPrecondition("this worker has no store");
  AttemptFolder folder;
  const std::string fence = std::to_string(lease.attempt().fence());
  folder.path = lease.store_prefix() + "/.attempt-" + fence;
  RETURN_IF_ERROR(CheckStorePath(folder.path));
  folder.scratch = options_.staging + "/" + fence + ".work";
  if (store_ != nullptr) {
    folder.store = store_;
    const absl::StatusOr<std::string> local = store_->LocalPath(folder.path);
    if (local.ok()) {
      folder.dir = *local;
      return folder;
    }
    folder.send_to = store_;
  } else {
    folder.send_to = MakeRemoteStore(channel_, {options_.worker, lease.attempt()});
    folder.store = folder.send_to;
  }
  folder.dir = options_.staging + "/" + fence;
  return folder;
}

}  // namespace parallax
