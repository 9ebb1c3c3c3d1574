#include "coordinator/client/archive_sync.h"

#include <filesystem>

namespace parallax::client {
namespace {

constexpr int kFramesAtOnce = 500;

}  // namespace

absl::StatusOr<std::string> LocalStoreFolder(const std::string& store_uri) {
  const std::string scheme = "file://";
  if (store_uri.rfind(scheme, 0) != 0) {
    return MakeError(absl::StatusCode::kFailedPrecondition,
                     "the coordinator's store is " + (store_uri.empty() ? "unknown" : store_uri) +
                         ", not a folder; only a store that is a folder can be read from here");
  }
  const std::string folder = store_uri.substr(scheme.size());
  std::error_code error;
  if (!std::filesystem::is_directory(folder, error)) {
    return MakeError(absl::StatusCode::kFailedPrecondition,
                     "the coordinator's store is the folder " + folder +
                         " of its machine, which can't be seen from here; run this command there, "
                         "or mount the folder at the same path");
  }
  return folder;
}

absl::StatusOr<std::unique_ptr<ArchiveSync>> ArchiveSync::Open(const std::string& out_dir,
                                                               const v1::StudySpec& study) {
  ASSIGN_OR_RETURN(auto writer, ArchiveWriter::Open(out_dir, study));
  return std::unique_ptr<ArchiveSync>(new ArchiveSync(std::move(writer)));
}

absl::Status ArchiveSync::CatchUp(Connection& connection, int64_t study_id) {
  while (true) {
    ASSIGN_OR_RETURN(const v1::ListFramesReply reply,
                     connection.ListFrames(study_id, cursor_, kFramesAtOnce));
    if (reply.frames_size() == 0) break;
    ASSIGN_OR_RETURN(const std::string store, LocalStoreFolder(reply.store_uri()));
    for (const v1::PublishedFrame& frame : reply.frames()) {
      if (!writer_->HasScene(frame.variant(), frame.scene())) {
        ASSIGN_OR_RETURN(const v1::GetSceneReply scene,
                         connection.GetScene(study_id, frame.variant(), frame.scene()));
        RETURN_IF_ERROR(writer_->AddScene(frame.variant(), frame.scene(), scene.scene()));
      }
      RETURN_IF_ERROR(writer_->AddFrame(frame, store));
      cursor_ = frame.cursor();
    }
    if (reply.frames_size() < kFramesAtOnce) break;
  }
  return absl::OkStatus();
}

}  // namespace parallax::client
