#include "tests/faults/simulate/shared_disk.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "common/base/hash.h"
#include "common/store/store.h"
#include "parallax/v1/train.pb.h"
#include "tests/job_messages.h"

namespace parallax::faults {
namespace {

namespace fs = std::filesystem;

std::string BytesOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Puts a small file, whose content tells its place.
void PutFile(Store& store, const std::string& folder, v1::FileEntry& file) {
  const std::string path = folder + "/" + file.name();
  if (!store.Put(path, path).ok()) std::abort();
  file.set_size(static_cast<int64_t>(path.size()));
  file.set_sha256(Sha256Hex(path));
}

template <typename Result>
void PutFilesOf(Store& store, v1::CompleteRequest& report) {
  Result result;
  result.ParseFromString(report.result());
  for (v1::FileEntry& file : *result.mutable_files()) PutFile(store, result.path(), file);
  report.set_result(result.SerializeAsString());
}

}  // namespace

void SharedDisk::PutFiles(v1::CompleteRequest& report) const {
  const auto store = OpenStore(uri(), {.create = false});
  if (!store.ok()) std::abort();
  if (report.kind() == "train") PutFilesOf<v1::TrainResult>(**store, report);
  if (report.kind() == "evaluate") PutFilesOf<v1::EvaluateResult>(**store, report);
  if (report.kind() != "render") return;
  EditRender(report, [&](v1::RenderResult& result) {
    for (v1::FrameResult& frame : *result.mutable_frames()) {
      for (v1::FileEntry& file : *frame.mutable_files()) PutFile(**store, frame.path(), file);
    }
  });
}

std::string SharedDisk::Lie(Rng& dice) {
  std::vector<std::string> paths;
  std::error_code gone;
  for (const auto& entry : fs::recursive_directory_iterator(root_, gone)) {
    const std::string path = entry.path().lexically_relative(root_);
    if (entry.is_regular_file() && path.find("/.attempt-") != std::string::npos) {
      paths.push_back(path);
    }
  }
  if (paths.empty()) return "";
  std::sort(paths.begin(), paths.end());  // The disk's order is another each time.
  std::string path = dice.Pick(paths);
  const int draw = dice.UniformInt(0, 2);
  if (draw == 0) path.resize(path.find('/', path.find("/.attempt-") + 1));
  lies_.insert(path);
  if (draw < 2) {
    fs::remove_all(root_ + "/" + path);
    return path + " is removed";
  }
  std::string bytes = BytesOf(root_ + "/" + path);
  bytes[static_cast<size_t>(dice.UniformInt(0, static_cast<int>(bytes.size()) - 1))] ^=
      static_cast<char>(1 << dice.UniformInt(0, 7));
  std::ofstream(root_ + "/" + path, std::ios::binary) << bytes;
  return "a bit of " + path + " is flipped";
}

bool SharedDisk::HasLiedAbout(const std::string& folder) const {
  return std::any_of(lies_.begin(), lies_.end(), [&](const std::string& path) {
    return path.starts_with(folder) || folder.starts_with(path);
  });
}

bool SharedDisk::Has(const JobKind::OutputFile& file) const {
  const std::string path = root_ + "/" + file.path;
  return fs::exists(path) && Sha256Hex(BytesOf(path)) == file.sha256;
}

}  // namespace parallax::faults
