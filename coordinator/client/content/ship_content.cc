#include "coordinator/client/content/ship_content.h"

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
#include "worker/evaluate/own_benchmark.h"
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

  // Ships what an own benchmark reads; a list goes as a folder with a list that names its files.
  absl::Status ShipBenchmark(v1::OwnBenchmark* own) {
    const std::string path = FromRoot(PathOfBenchmark(*own));
    std::error_code error;
    if (!std::filesystem::exists(path, error)) return absl::OkStatus();
    ASSIGN_OR_RETURN(const OwnBenchmarkFiles found, ReadOwnBenchmark(*own, path));
    std::vector<ContentFile> files;
    for (const OwnBenchmarkFile& file : found.files) files.push_back(file.file);
    RETURN_IF_ERROR(CheckContentSizes(files, path));
    for (const OwnBenchmarkFile& file : found.files) {
      if (!file.path.empty()) {
        RETURN_IF_ERROR(ShipFile(file.path, file.file));
        continue;
      }
      RETURN_IF_ERROR(
          Patiently([&] { return store_.Put(ContentPath(file.file.sha256), found.list); }));
    }
    return ShipList(files, path, [own](const std::string& text) { SetPath(text, *own); });
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
    for (const ContentFile& file : files) RETURN_IF_ERROR(ShipFile(dir + "/" + file.name, file));
    return ShipList(files, dir, [folder](const std::string& text) { *folder = text; });
  }

  // `set` gets the text that names the list and, from "/", `path`.
  template <typename Set>
  absl::Status ShipList(const std::vector<ContentFile>& files, const std::string& path, Set set) {
    const std::string list = ContentListText(files);
    RETURN_IF_ERROR(ParseContentList(list).status());
    const std::string sha256 = Sha256Hex(list);
    RETURN_IF_ERROR(Patiently([&] { return store_.Put(ContentPath(sha256), list); }));
    ++shipped_.folders;
    set(ContentReferenceText({sha256, path.substr(1)}));
    return absl::OkStatus();
  }

  absl::Status ShipFile(const std::string& path, const ContentFile& file) {
    const StoreFile facts{file.size, file.sha256};
    const absl::Status status = Patiently(
        [&] { return store_.PutFile(ContentPath(file.sha256), path, facts, /*may_move=*/false); });
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
  for (int i = 0; i < study.evaluate().own_benchmarks_size(); ++i) {
    v1::OwnBenchmark& own = *study.mutable_evaluate()->mutable_own_benchmarks(i);
    const absl::Status status = shipper.ShipBenchmark(&own);
    if (!status.ok()) return WithContext(status, "own benchmark " + own.name());
  }
  return shipper.shipped();
}

void NameOwnCopies(v1::StudySpec& study) {
  for (v1::VariantSpec& variant : *study.mutable_variants()) {
    for (std::string* folder : ContentFoldersOf(*variant.mutable_config())) {
      if (const auto reference = FindContentReference(*folder)) *folder = reference->path;
    }
  }
  for (int i = 0; i < study.evaluate().own_benchmarks_size(); ++i) {
    v1::OwnBenchmark& own = *study.mutable_evaluate()->mutable_own_benchmarks(i);
    if (const auto reference = FindContentReference(PathOfBenchmark(own)))
      SetPath(reference->path, own);
  }
}

}  // namespace parallax::client
