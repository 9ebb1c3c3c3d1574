#include "worker/jobs/files/finished_frames.h"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/base/system/log.h"
#include "common/config/frame_files.h"
#include "common/config/frame_notes.h"
#include "common/store/store.h"
#include "worker/dataset/frame/render_frames.h"
#include "worker/jobs/files/store_files.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

std::string RigFolder(uint32_t rig) { return fmt::format("{:03}", rig); }

std::string NoteOf(uint32_t rig) { return std::string(kFrameNotes) + "/" + RigFolder(rig) + ".pb"; }

std::vector<std::string> FileNamesOf(const v1::FrameResult& frame) {
  std::vector<std::string> names;
  for (const v1::FileEntry& file : frame.files()) names.push_back(file.name());
  std::sort(names.begin(), names.end());
  return names;
}

// A second name of the file, else a copy, durable but for its entry in the folder.
absl::Status LinkOrCopy(const std::string& from, const std::string& to) {
  if (::link(from.c_str(), to.c_str()) == 0) return absl::OkStatus();
  std::error_code error;
  fs::copy_file(from, to, fs::copy_options::overwrite_existing, error);
  if (error) return ErrnoError(error.value(), "copy " + from);
  return SyncPath(to);
}

absl::Status BringFile(const Store& store, const std::string& from, const v1::FileEntry& file,
                       const std::string& to) {
  const absl::StatusOr<std::string> local = store.LocalPath(from);
  if (local.ok()) {
    RETURN_IF_ERROR(LinkOrCopy(*local, to));
  } else {
    ASSIGN_OR_RETURN(const std::string bytes, GetWhole(store, from, file.size()));
    RETURN_IF_ERROR(WriteFileAtomically(to, bytes));
  }
  ASSIGN_OR_RETURN(const std::string hash, Sha256HexOfFile(to));
  if (hash == file.sha256()) return absl::OkStatus();
  return DataLoss("{} is not what its note says", from);
}

}  // namespace

absl::Status FinishedFrames::SendAndNote(const v1::FrameResult& frame) {
  const std::string name = RigFolder(frame.rig());
  if (folder_.send_to != nullptr) {
    for (const v1::FileEntry& file : frame.files()) {
      const std::string path = name + "/" + file.name();
      RETURN_IF_ERROR(folder_.send_to->PutFile(folder_.path + "/" + path, folder_.dir + "/" + path,
                                               {file.size(), file.sha256()}, /*may_move=*/false));
    }
    sent_.insert(frame.rig());
    return folder_.send_to->Put(folder_.path + "/" + NoteOf(frame.rig()),
                                frame.SerializeAsString());
  }
  RETURN_IF_ERROR(MakeFolders(folder_.dir + "/" + kFrameNotes));
  RETURN_IF_ERROR(SyncPath(folder_.dir));  // A note on disk tells of a frame on disk.
  return WriteFileAtomically(folder_.dir + "/" + NoteOf(frame.rig()), frame.SerializeAsString());
}

void FinishedFrames::Note(const v1::FrameResult& frame) {
  const absl::Status status = SendAndNote(frame);
  if (status.ok()) {
    noted_.insert(frame.rig());
  } else {
    LogWarning("a finished pair is not kept for later attempts",
               {{"rig", frame.rig()}, {"error", status}});
  }
}

absl::StatusOr<v1::FrameResult> FinishedFrames::TakeOverFrom(const std::string& earlier,
                                                             uint32_t rig,
                                                             const v1::RenderConfig& render) {
  ASSIGN_OR_RETURN(const std::string note, folder_.store->Get(earlier + "/" + NoteOf(rig)));
  v1::FrameResult frame;
  if (!frame.ParseFromString(note) || frame.rig() != rig ||
      !AreFrameFiles(FileNamesOf(frame), render)) {
    return DataLoss("the note on rig {} in {} is none of this job's", rig, earlier);
  }
  const std::string dir = folder_.dir + "/" + RigFolder(rig);
  std::error_code ignored;
  fs::remove_all(dir, ignored);
  RETURN_IF_ERROR(MakeFolders(dir));
  for (const v1::FileEntry& file : frame.files()) {
    RETURN_IF_ERROR(BringFile(*folder_.store, earlier + "/" + RigFolder(rig) + "/" + file.name(),
                              file, dir + "/" + file.name()));
  }
  RETURN_IF_ERROR(SyncPath(dir));
  RETURN_IF_ERROR(SyncPath(folder_.dir));
  frame.set_path(folder_.path + "/" + RigFolder(rig));
  return frame;
}

absl::StatusOr<std::vector<v1::FrameResult>> FinishedFrames::TakeOver(const v1::RenderJob& job,
                                                                      const CancelToken& cancel) {
  std::vector<v1::FrameResult> taken;
  if (job.earlier_folders().empty() || folder_.store == nullptr) return taken;
  RETURN_IF_ERROR(MakeAttemptFolder(folder_.dir));
  for (const uint32_t rig : job.rigs()) {
    for (const std::string& earlier : job.earlier_folders()) {
      if (cancel.cancelled()) return Cancelled("while pairs were taken over");
      absl::StatusOr<v1::FrameResult> frame = TakeOverFrom(earlier, rig, job.render());
      if (frame.ok()) {
        // A job of one pair leaves it where it was found, too.
        if (job.rigs_size() > 1) Note(*frame);
        taken.push_back(*std::move(frame));
        break;
      }
      if (absl::IsNotFound(frame.status())) continue;
      LogWarning("a finished pair can't be taken over", {{"rig", rig}, {"error", frame.status()}});
    }
  }
  LogInfo("pairs of earlier attempts are taken over",
          {{"pairs", taken.size()}, {"of", job.rigs_size()}});
  return taken;
}

void FinishedFrames::RemoveUnfinished() {
  std::set<std::string> stay = {kFrameNotes};
  for (const uint32_t rig : noted_) stay.insert(RigFolder(rig));
  std::error_code ignored;
  std::vector<fs::path> go;
  for (const auto& entry : fs::directory_iterator(folder_.dir, ignored)) {
    if (stay.count(entry.path().filename()) == 0) go.push_back(entry.path());
  }
  for (const fs::path& path : go) fs::remove_all(path, ignored);
}

}  // namespace parallax
