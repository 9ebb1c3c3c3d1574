// Keeps a dataset folder up to date with a study: each call copies the frames that were published
// since the last one out of the coordinator's store. Frames in the folder are left alone.
//
// Not thread-safe. Borrows the connection of each call.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "coordinator/client/connection.h"
#include "coordinator/client/runs/store_reader.h"
#include "parallax/v1/study.pb.h"
#include "worker/dataset/archive/archive.h"

namespace parallax::client {

class ArchiveSync {
 public:
  // Opens the dataset in `out_dir`, or creates it. With `verify`, files of the store that this
  // machine sees are read and compared with their hashes before they are linked, and pairs that are
  // damaged are left out. Errors: those of ArchiveWriter::Open.
  static absl::StatusOr<std::unique_ptr<ArchiveSync>> Open(const std::string& out_dir,
                                                           const v1::StudySpec& study,
                                                           bool verify = false);

  // Adds all frames that are published by now. Links files if this machine can see the store, else
  // streams them through the coordinator. Errors: the connection's, the store's and the archive's.
  absl::Status CatchUp(Connection& connection, int64_t study_id);
  // Writes the index and the card of the dataset. It reads the whole folder, so call it now and
  // then rather than after each frame. Errors: those of ArchiveWriter::Finish.
  absl::Status Finish() { return writer_->Finish(); }

  const ArchiveWriter& writer() const { return *writer_; }
  int64_t files_streamed() const { return files_streamed_; }
  // Returns what is wrong with each pair that was left out: "narrow, scene 5, rig 2: ...".
  const std::vector<std::string>& damaged() const { return damaged_; }

 private:
  ArchiveSync(std::string out_dir, std::unique_ptr<ArchiveWriter> writer, bool verify)
      : out_dir_(std::move(out_dir)), writer_(std::move(writer)), verify_(verify) {}
  bool IsArchived(const v1::PublishedFrame& frame) const;
  absl::Status AddFrame(const v1::PublishedFrame& frame);

  const std::string out_dir_;
  std::unique_ptr<ArchiveWriter> writer_;
  const bool verify_;
  std::vector<std::string> damaged_;
  std::unique_ptr<StoreReader> store_;  // From the first frame on.
  int64_t cursor_ = 0;
  int64_t files_streamed_ = 0;
};

}  // namespace parallax::client
