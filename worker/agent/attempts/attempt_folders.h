// The folders that attempts write to: in the store itself if this machine sees it, else staging
// folders on this machine, whose files are sent to the store, directly or through the coordinator.
//
// Not thread-safe.
#pragma once

#include <grpcpp/channel.h>

#include <functional>
#include <memory>
#include <string>

#include "common/base/status.h"
#include "common/store/store.h"
#include "common/store/store_guard.h"
#include "parallax/v1/service.pb.h"
#include "worker/agent/attempts/job_handler.h"

namespace parallax {

// Chooses the folders of attempts according to the coordinator's store.
class AttemptFolders {
 public:
  struct Options {
    std::string store_uri;  // Overrides the coordinator's: the same store under another path.
    std::string staging;    // Folder for what is to be sent.
    std::string worker;
    double store_look_s = 2;              // Time between two looks whether the store is there.
    std::function<void()> store_changed;  // Called from another thread when it went or is back.
  };
  AttemptFolders(Options options, std::shared_ptr<grpc::Channel> channel);

  // Opens the store that the coordinator names, unless it is open already.
  // Errors: those of OpenStore, if the worker must see the store itself.
  absl::Status Use(const v1::Welcome& welcome);
  // Returns whether the store that this machine sees was still there at the last look, under its
  // name and with the id that the coordinator's database knows. Never waits for the store.
  bool StoreIsThere() const { return guard_ == nullptr || guard_->status().ok(); }
  // Has it looked for at once.
  void LookSoon() {
    if (guard_ != nullptr) guard_->LookSoon();
  }
  // Returns the folder for an attempt that writes. Errors: kFailedPrecondition without a store;
  // kInvalidArgument for a path that leaves the store.
  absl::StatusOr<AttemptFolder> Of(const v1::Lease& lease) const;
  // Returns the folder of a job that writes nothing. It has only the store to read from, through
  // the coordinator unless this machine sees the store.
  AttemptFolder ReadOnly(const v1::Lease& lease) const;

 private:
  const Options options_;
  const std::shared_ptr<grpc::Channel> channel_;
  std::shared_ptr<Store> store_;       // Null: through the coordinator.
  std::unique_ptr<StoreGuard> guard_;  // Watches store_; null without it.
  std::string key_;                    // The store as the coordinator named it; "" before.
};

}  // namespace parallax
