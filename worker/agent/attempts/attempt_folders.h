// The folders that attempts write to: in the store itself if this machine sees it, else staging
// folders on this machine, whose files are sent to the store, directly or through the coordinator.
//
// Not thread-safe.
#pragma once

#include <grpcpp/channel.h>

#include <memory>
#include <string>

#include "common/base/status.h"
#include "common/store/store.h"
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
  };
  AttemptFolders(Options options, std::shared_ptr<grpc::Channel> channel);

  // Opens the store that the coordinator names, unless it is open already.
  // Errors: those of OpenStore, if the worker must see the store itself.
  absl::Status Use(const v1::Welcome& welcome);
  // Looks whether the store that this machine sees is still there, under its name and with the id
  // that the coordinator's database knows. Errors: those of Store::CheckMarker.
  absl::Status CheckStore() const;
  // Returns the folder for an attempt that writes. Errors: kFailedPrecondition without a store;
  // kInvalidArgument for a path that leaves the store.
  absl::StatusOr<AttemptFolder> Of(const v1::Lease& lease) const;
  // Returns the folder of a job that writes nothing. It has only the store to read from, through
  // the coordinator unless this machine sees the store.
  AttemptFolder ReadOnly(const v1::Lease& lease) const;

 private:
  const Options options_;
  const std::shared_ptr<grpc::Channel> channel_;
  std::shared_ptr<Store> store_;  // Null: through the coordinator.
  std::string key_;               // The store as the coordinator named it; "" before.
};

}  // namespace parallax
