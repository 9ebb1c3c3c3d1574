#include "coordinator/client/content/ship_content.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "common/base/hash.h"
#include "common/config/content_folders.h"
#include "common/store/content.h"
#include "coordinator/client/content/study_options.h"
#include "worker/materials/pictures/picture_folder.h"

namespace parallax::client {
namespace {

// Extensions of meshes and what lies beside them, textures, surroundings and pictures.
constexpr std::string_view kEndings[] = {".glb", ".obj",  ".ply", ".mtl", ".png",
                                         ".jpg", ".jpeg", ".hdr", ".exr"};
constexpr int kTries = 5;

// A coordinator that is busy is asked again.
template <typename Function>
absl::Status Patiently(Function function) {
  for (int attempt = 1;; ++attempt) {
    const absl::Status status = function();
    if (!absl::IsUnavailable(status) || attempt == kTries) return status;
    std::this_thread::sleep_for(std::chrono::milliseconds(200 * attempt));
  }
}

class Shipper {
 public:
  explicit Shipper(Store& store) : store_(store) {}

  absl::Status Ship(std::string* folder) {
    if (const auto known = references_.find(*folder); known != references_.end()) {
      *folder = known->second;
      return absl::OkStatus();
    }
    const std::string name = *folder;
    const absl::Status status = ShipFolder(FromRoot(name), folder);
    if (!status.ok()) return WithContext(status, "own content of " + FromRoot(name));
    references_[name] = *folder;
    return absl::OkStatus();
  }

  const ShippedContent& shipped() const { return shipped_; }

 private:
  absl::Status ShipFolder(const std::string& dir, std::string* folder) {
    const absl::StatusOr<std::vector<FolderFile>> found = ReadContentFolder(dir, kEndings);
    if (absl::IsNotFound(found.status())) return absl::OkStatus();
    RETURN_IF_ERROR(found.status());
    std::vector<ContentFile> files;
    for (const FolderFile& file : *found) {
      std::error_code error;
      const auto size = std::filesystem::file_size(dir + "/" + file.name, error);
      if (error) return ErrnoError(error.value(), "read " + dir + "/" + file.name);
      files.push_back({file.name, static_cast<int64_t>(size), file.sha256});
    }
    RETURN_IF_ERROR(CheckContentSizes(files, dir));
    const std::string list = ContentListText(files);
    RETURN_IF_ERROR(ParseContentList(list).status());
    for (const ContentFile& file : files) RETURN_IF_ERROR(ShipFile(dir, file));
    const std::string sha256 = Sha256Hex(list);
    RETURN_IF_ERROR(Patiently([&] { return store_.Put(ContentPath(sha256), list); }));
    ++shipped_.folders;
    *folder = ContentReferenceText({sha256, dir.substr(1)});
    return absl::OkStatus();
  }

  absl::Status ShipFile(const std::string& dir, const ContentFile& file) {
    const StoreFile facts{file.size, file.sha256};
    const absl::Status status = Patiently([&] {
      return store_.PutFile(ContentPath(file.sha256), dir + "/" + file.name, facts,
                            /*may_move=*/false);
    });
    if (!status.ok()) return WithContext(status, file.name);
    ++shipped_.files;
    shipped_.bytes += file.size;
    return absl::OkStatus();
  }

  Store& store_;
  std::map<std::string, std::string> references_;  // By the folder's name.
  ShippedContent shipped_;
};

}  // namespace

absl::StatusOr<ShippedContent> ShipContent(v1::StudySpec& study, Store& store) {
  Shipper shipper(store);
  for (v1::VariantSpec& variant : *study.mutable_variants()) {
    if (!variant.has_config()) continue;
    for (std::string* folder : ContentFoldersOf(*variant.mutable_config())) {
      RETURN_IF_ERROR(shipper.Ship(folder));
    }
  }
  return shipper.shipped();
}

void NameOwnCopies(v1::StudySpec& study) {
  for (v1::VariantSpec& variant : *study.mutable_variants()) {
    for (std::string* folder : ContentFoldersOf(*variant.mutable_config())) {
      if (const auto reference = FindContentReference(*folder)) *folder = reference->path;
    }
  }
}

}  // namespace parallax::client
