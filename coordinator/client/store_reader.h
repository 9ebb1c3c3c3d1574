// Where a client reads the files of published frames from: the coordinator's store itself where
// this machine sees it (hard links then cost nothing), else streams through the coordinator.
//
// Not thread-safe. Borrows the connection.
#pragma once

#include <memory>
#include <string>

#include "common/base/status.h"
#include "coordinator/client/connection.h"

namespace parallax {
class Store;
}

namespace parallax::client {

class StoreReader {
 public:
  // Asks the coordinator where its store is. `scratch` is for files on their way: on the disk of
  // the dataset, made when needed. Errors: the connection's.
  static absl::StatusOr<std::unique_ptr<StoreReader>> Open(Connection& connection,
                                                           const std::string& scratch);
  ~StoreReader();  // Removes the scratch folder.

  // The folder below which a frame's files stand, or are to be brought with Bring.
  const std::string& folder() const { return folder_; }
  bool is_local() const { return store_ == nullptr; }
  // Streams the frame's files into folder(), checked against their hashes. Not for a local store.
  // Errors: kDataLoss for a file that is not what its manifest says; the store's.
  absl::Status Bring(const v1::FrameResult& frame);
  // Removes what Bring brought.
  void Drop(const v1::FrameResult& frame);

 private:
  StoreReader(std::string folder, std::unique_ptr<Store> store);

  const std::string folder_;
  const std::unique_ptr<Store> store_;  // Null: the folder is the store.
};

}  // namespace parallax::client
