#include "coordinator/client/runs/archive_sync.h"

#include <fmt/core.h>
#include <unistd.h>

#include <filesystem>

#include "common/base/names.h"
#include "common/config/check/notify_check.h"
#include "common/store/store.h"
#include "worker/dataset/archive/archive_index.h"

namespace parallax::client {
namespace {

constexpr int kFramesAtOnce = 500;

// Checks names that become folders and files here: another client may have chosen them.
absl::Status CheckNames(const v1::PublishedFrame& frame) {
  RETURN_IF_ERROR(CheckName("variant", frame.variant()));
  RETURN_IF_ERROR(CheckStorePath(frame.frame().path()));
  for (const v1::FileEntry& file : frame.frame().files()) {
    RETURN_IF_ERROR(CheckName("file", file.name()));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<ArchiveSync>> ArchiveSync::Open(const std::string& out_dir,
                                                               const v1::StudySpec& study,
                                                               bool verify) {
  for (const v1::VariantSpec& variant : study.variants()) {
    RETURN_IF_ERROR(CheckName("variant", variant.name()));
  }
  v1::StudySpec shown = study;  // Datasets are given to others.
  TakeNotify(&shown);
  ASSIGN_OR_RETURN(auto writer, ArchiveWriter::Open(out_dir, shown));
  return std::unique_ptr<ArchiveSync>(new ArchiveSync(out_dir, std::move(writer), verify));
}

absl::Status ArchiveSync::CatchUp(Connection& connection, int64_t study_id) {
  while (true) {
    ASSIGN_OR_RETURN(const v1::ListFramesReply reply,
                     connection.ListFrames(study_id, cursor_, kFramesAtOnce));
    if (reply.frames_size() == 0) break;
    if (store_ == nullptr) {
      ASSIGN_OR_RETURN(
          store_, StoreReader::Open(connection, fmt::format("{}/.fetch-{}", out_dir_, ::getpid())));
    }
    for (const v1::PublishedFrame& frame : reply.frames()) {
      RETURN_IF_ERROR(CheckNames(frame));
      if (!writer_->HasScene(frame.variant(), frame.scene())) {
        ASSIGN_OR_RETURN(const v1::GetSceneReply scene,
                         connection.GetScene(study_id, frame.variant(), frame.scene()));
        RETURN_IF_ERROR(writer_->AddScene(frame.variant(), frame.scene(), scene.scene()));
      }
      const absl::Status added = AddFrame(frame);
      if (verify_ && (absl::IsDataLoss(added) || absl::IsNotFound(added))) {
        damaged_.push_back(fmt::format("{}, scene {}, rig {}: {}", frame.variant(), frame.scene(),
                                       frame.frame().rig(), ToStd(added.message())));
      } else {
        RETURN_IF_ERROR(added);
      }
      cursor_ = frame.cursor();
    }
  }
  return absl::OkStatus();
}

bool ArchiveSync::IsArchived(const v1::PublishedFrame& frame) const {
  std::error_code error;
  return std::filesystem::exists(
      out_dir_ + "/" + frame.variant() + "/" + FramePath({frame.scene(), frame.frame().rig()}),
      error);
}

// A frame that is there already needs nothing of the store.
absl::Status ArchiveSync::AddFrame(const v1::PublishedFrame& frame) {
  if (verify_ && store_->is_local() && !IsArchived(frame)) {
    RETURN_IF_ERROR(store_->Verify(frame.frame()));
  }
  const absl::Status status = writer_->AddFrame(frame, store_->folder());
  if (store_->is_local() || !absl::IsNotFound(status)) return status;
  const absl::Status brought = store_->Bring(frame.frame());
  if (absl::IsUnimplemented(brought)) {
    return FailedPrecondition(
        "the coordinator's store can't be seen from here, and this coordinator's version does "
        "not send files; run this command on its machine, or mount the store at the same "
        "path");
  }
  RETURN_IF_ERROR(brought);
  files_streamed_ += frame.frame().files_size();
  RETURN_IF_ERROR(writer_->AddFrame(frame, store_->folder()));
  store_->Drop(frame.frame());
  return absl::OkStatus();
}

}  // namespace parallax::client
