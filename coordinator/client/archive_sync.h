// Keeps a dataset folder in step with a study: brings what has been published since the last call
// out of the coordinator's store. What is there already is left alone.
//
// Not thread-safe. Borrows the connection.
#pragma once

#include <memory>
#include <string>

#include "common/base/status.h"
#include "coordinator/client/connection.h"
#include "parallax/v1/study.pb.h"
#include "worker/dataset/archive.h"

namespace parallax::client {

class ArchiveSync {
 public:
  // Errors: those of ArchiveWriter::Open.
  static absl::StatusOr<std::unique_ptr<ArchiveSync>> Open(const std::string& out_dir,
                                                           const v1::StudySpec& study);

  // All frames published by now. Errors: the connection's and the archive's; kFailedPrecondition
  // when the coordinator's store isn't a folder that this machine sees.
  absl::Status CatchUp(Connection& connection, int64_t study_id);
  // Index and card of what is there; they read everything, so not after each frame.
  absl::Status Finish() { return writer_->Finish(); }

  const ArchiveWriter& writer() const { return *writer_; }

 private:
  explicit ArchiveSync(std::unique_ptr<ArchiveWriter> writer) : writer_(std::move(writer)) {}

  std::unique_ptr<ArchiveWriter> writer_;
  int64_t cursor_ = 0;
};

// The folder of a "file:///..." store. Errors: kFailedPrecondition when it isn't one or can't be
// seen from here.
absl::StatusOr<std::string> LocalStoreFolder(const std::string& store_uri);

}  // namespace parallax::client
