// Reads the files of published frames: from the coordinator's store itself if this machine can see
// it (hard links then cost nothing), else by streams through the coordinator.
//
// Not thread-safe. Uses the connection only in Open.
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
  // Asks the coordinator where its store is. `scratch` is a folder for streamed files on the
  // dataset's disk; it is made when needed. Errors: the connection's.
  static absl::StatusOr<std::unique_ptr<StoreReader>> Open(Connection& connection,
                                                           const std::string& scratch);
  ~StoreReader();  // Removes the scratch folder.

  // Returns the folder with the frames' files: the store itself, or the scratch folder that Bring
  // fills.
  const std::string& folder() const { return folder_; }
  bool is_local() const { return store_ == nullptr; }
  // Reads a frame's files in folder() and compares them with their hashes. Only if is_local().
  // Errors: kNotFound and kDataLoss, naming the file; the disk's.
  absl::Status Verify(const v1::FrameResult& frame) const;
  // Streams a frame's files into folder() and checks their hashes. Only if not is_local().
  // Errors: kDataLoss for a file that differs from its manifest; the store's.
  absl::Status Bring(const v1::FrameResult& frame);
  // Removes the files that Bring has streamed for this frame.
  void Drop(const v1::FrameResult& frame);

 private:
  StoreReader(std::string folder, std::unique_ptr<Store> store);

  const std::string folder_;
  const std::unique_ptr<Store> store_;  // Null: the folder is the store.
};

}  // namespace parallax::client
