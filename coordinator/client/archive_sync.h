// Keeps a dataset folder in step with a study: brings what has been published since the last call
// out of the coordinator's store. What is there already is left alone.
//
// Not thread-safe. Borrows the connection.
#pragma once

#include <memory>
#include <string>

#include "common/base/status.h"
#include "coordinator/client/connection.h"
#include "coordinator/client/store_reader.h"
#include "parallax/v1/study.pb.h"
#include "worker/dataset/archive.h"

namespace parallax::client {

class ArchiveSync {
 public:
  // Errors: those of ArchiveWriter::Open.
  static absl::StatusOr<std::unique_ptr<ArchiveSync>> Open(const std::string& out_dir,
                                                           const v1::StudySpec& study);

  // All frames published by now. Files are linked from a store that this machine sees, and streamed
  // through the coordinator otherwise. Errors: the connection's, the store's and the archive's.
  absl::Status CatchUp(Connection& connection, int64_t study_id);
  // Index and card of what is there; they read everything, so not after each frame.
  // Errors: those of ArchiveWriter::Finish.
  absl::Status Finish() { return writer_->Finish(); }

  const ArchiveWriter& writer() const { return *writer_; }
  int64_t files_streamed() const { return files_streamed_; }

 private:
  ArchiveSync(std::string out_dir, std::unique_ptr<ArchiveWriter> writer)
      : out_dir_(std::move(out_dir)), writer_(std::move(writer)) {}
  absl::Status AddFrame(const v1::PublishedFrame& frame);

  const std::string out_dir_;
  std::unique_ptr<ArchiveWriter> writer_;
  std::unique_ptr<StoreReader> store_;  // From the first frame on.
  int64_t cursor_ = 0;
  int64_t files_streamed_ = 0;
};

}  // namespace parallax::client
