#include "coordinator/client/runs/store_reader.h"

#include <algorithm>
#include <filesystem>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/store/store.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;

constexpr size_t kPieceBytes = 8 << 20;

// The store's folder if this machine sees it, "" otherwise.
std::string LocalFolder(const v1::GetInfoReply& info) {
  const std::string scheme = "file://";
  if (info.store_uri().rfind(scheme, 0) != 0) return "";
  const std::string folder = info.store_uri().substr(scheme.size());
  if (info.store_id().empty()) {  // An older coordinator.
    std::error_code error;
    return fs::is_directory(folder, error) ? folder : "";
  }
  const auto store =
      OpenStore(info.store_uri(), {.create = false, .id = info.store_id(), .read_only = true});
  return store.ok() ? folder : "";
}

}  // namespace

absl::StatusOr<std::unique_ptr<StoreReader>> StoreReader::Open(Connection& connection,
                                                               const std::string& scratch) {
  ASSIGN_OR_RETURN(const v1::GetInfoReply info, connection.GetInfo());
  if (const std::string folder = LocalFolder(info); !folder.empty()) {
    return std::unique_ptr<StoreReader>(new StoreReader(folder, nullptr));
  }
  return std::unique_ptr<StoreReader>(new StoreReader(scratch, connection.RemoteStore()));
}

StoreReader::StoreReader(std::string folder, std::unique_ptr<Store> store)
    : folder_(std::move(folder)), store_(std::move(store)) {}

StoreReader::~StoreReader() {
  std::error_code ignored;
  if (store_ != nullptr) fs::remove_all(folder_, ignored);
}

absl::Status StoreReader::Bring(const v1::FrameResult& frame) {
  RETURN_IF_ERROR(CheckStorePath(frame.path()));
  std::error_code error;
  fs::create_directories(folder_ + "/" + frame.path(), error);
  if (error) return ErrnoError(error.value(), "make " + folder_);
  for (const v1::FileEntry& file : frame.files()) {
    const std::string path = frame.path() + "/" + file.name();
    RETURN_IF_ERROR(CheckStorePath(path));
    std::string bytes;
    while (static_cast<int64_t>(bytes.size()) < file.size()) {
      ASSIGN_OR_RETURN(
          const std::string piece,
          store_->GetPiece(path, static_cast<int64_t>(bytes.size()),
                           std::min(kPieceBytes, static_cast<size_t>(file.size()) - bytes.size())));
      if (piece.empty()) break;
      bytes += piece;
    }
    if (Sha256Hex(bytes) != file.sha256()) {
      return DataLoss("store file {}: its content is not what its manifest says", path);
    }
    RETURN_IF_ERROR(WriteFile(folder_ + "/" + path, bytes, /*sync=*/true));
  }
  return absl::OkStatus();
}

absl::Status StoreReader::Verify(const v1::FrameResult& frame) const {
  RETURN_IF_ERROR(CheckStorePath(frame.path()));
  for (const v1::FileEntry& file : frame.files()) {
    const std::string path = frame.path() + "/" + file.name();
    RETURN_IF_ERROR(CheckStorePath(path));
    ASSIGN_OR_RETURN(const std::string sha256, Sha256HexOfFile(folder_ + "/" + path));
    if (sha256 == file.sha256()) continue;
    return DataLoss("store file {}: its content is not what its manifest says", path);
  }
  return absl::OkStatus();
}

void StoreReader::Drop(const v1::FrameResult& frame) {
  std::error_code ignored;
  if (store_ != nullptr) fs::remove_all(folder_ + "/" + frame.path(), ignored);
}

}  // namespace parallax::client
