#include "coordinator/client/runs/out_dir.h"

#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <iterator>
#include <set>

#include "common/base/system/file.h"
#include "common/config/config.h"
#include "common/config/frame_maps.h"
#include "coordinator/client/views/text.h"
#include "coordinator/study/expansion.h"
#include "worker/dataset/archive/study_change.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;

absl::Status MakeFolder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (!error) return absl::OkStatus();
  if (error.value() == ENOTDIR || error.value() == EEXIST) {
    return FailedPrecondition("{}: a file is in the way", path);
  }
  // A missing place such as /proc/x is no place to write to, rather than a wrong name.
  if (error.value() == ENOENT) error = std::make_error_code(std::errc::permission_denied);
  return ErrnoError(error.value(), "can't make the folder " + path);
}

// Writes as a run would: a file, and to disk.
absl::Status Probe(const std::string& work_dir) {
  const std::string probe = work_dir + "/probe";
  const absl::Status written = WriteFile(probe, std::string(4096, 'x'), /*sync=*/true);
  unlink(probe.c_str());
  return written;
}

// A study's lock file alone is none: people copy it to run the study again.
bool IsDataset(const fs::path& dir) {
  std::error_code error;
  if (!fs::exists(dir / "study.lock.yaml", error)) return false;
  if (fs::is_directory(dir / ".parallax", error)) return true;
  for (const auto& entry : fs::directory_iterator(dir, error)) {
    if (fs::exists(entry.path() / "index.jsonl", error)) return true;
  }
  return false;
}

}  // namespace

absl::Status CheckNotInDataset(const std::string& path) {
  std::error_code error;
  fs::path absolute = fs::weakly_canonical(fs::absolute(path, error), error);
  if (!absolute.has_filename()) absolute = absolute.parent_path();  // Ended in a slash.
  if (IsDataset(absolute)) return absl::OkStatus();
  for (fs::path dir = absolute; dir != dir.parent_path();) {
    dir = dir.parent_path();
    if (!IsDataset(dir)) continue;
    return FailedPrecondition("{} lies in the dataset {} itself: choose another folder", path,
                              dir.string());
  }
  return absl::OkStatus();
}

bool HoldsForeignFiles(const std::string& path) {
  std::error_code error;
  if (fs::exists(path + "/.parallax", error) || fs::exists(path + "/study.lock.yaml", error)) {
    return false;
  }
  return fs::is_directory(path, error) && !fs::is_empty(path, error);
}

absl::StatusOr<std::unique_ptr<OutDir>> OutDir::Open(const std::string& path) {
  if (path.empty()) return InvalidArgument("--out: an empty path");
  std::error_code error;
  std::string absolute = fs::absolute(path, error).lexically_normal();
  while (absolute.size() > 1 && absolute.back() == '/') absolute.pop_back();
  if (fs::exists(absolute, error) && !fs::is_directory(absolute, error)) {
    return FailedPrecondition("{}: not a folder, so no dataset can be written there", absolute);
  }
  RETURN_IF_ERROR(CheckNotInDataset(absolute));
  const std::string work_dir = absolute + "/.parallax";
  RETURN_IF_ERROR(MakeFolder(work_dir));
  ASSIGN_OR_RETURN(FolderLock lock,
                   FolderLock::Take(work_dir, absolute, "or choose another --out"));
  std::unique_ptr<OutDir> dir(new OutDir(absolute, std::move(lock)));
  RETURN_IF_ERROR(WithContext(Probe(work_dir), "can't write to " + absolute));
  RETURN_IF_ERROR(dir->CheckFreeSpace());
  return dir;
}

int64_t FreeBytesOf(const std::string& path) {
  const auto space = SpaceOfDisk(path);
  return space.ok() ? space->free_bytes : -1;
}

absl::Status CheckFreeSpaceOf(const std::string& path) {
  const int64_t free = FreeBytesOf(path);
  if (free < 0 || free >= kLeastFreeBytes) return absl::OkStatus();
  return ResourceExhausted("the disk of {} is full: {} free, at least {} needed", path,
                           FormatBytes(static_cast<double>(free)),
                           FormatBytes(static_cast<double>(kLeastFreeBytes)));
}

namespace {

// Bytes of a pair for each pixel of one image, measured on indoor scenes at 320x180.
double BytesPerPixel(const v1::RenderConfig& render) {
  double bytes = 0;
  for (const FrameMap& row : FrameMaps()) {
    if (row.IsIn(render)) bytes += row.bytes * static_cast<double>(row.Files().size());
  }
  return bytes;
}

}  // namespace

int64_t EstimateBytes(const v1::StudySpec& study) {
  double bytes = 0;
  for (const v1::VariantSpec& variant : study.variants()) {
    const v1::RigConfig& rigs = variant.config().rigs();
    const double pixels = static_cast<double>(rigs.width_px()) * rigs.height_px();
    bytes += static_cast<double>(PairsOf(study, variant)) * pixels *
             BytesPerPixel(variant.config().render());
  }
  return static_cast<int64_t>(bytes);
}

namespace {

int64_t PairsThereOf(const std::string& variant_dir) {
  int64_t pairs = 0;
  std::error_code error;
  for (const auto& scene : fs::directory_iterator(variant_dir + "/frames", error)) {
    const fs::directory_iterator rigs(scene.path(), error);
    pairs += std::distance(fs::begin(rigs), fs::end(rigs));
  }
  return pairs;
}

}  // namespace

int64_t EstimateMissingBytes(const v1::StudySpec& study, const std::string& out_dir) {
  const absl::StatusOr<v1::StudySpec> before = LoadStudy(out_dir + "/study.lock.yaml");
  if (!before.ok()) return EstimateBytes(study);
  std::set<std::string> dropped;
  for (const DroppedPart& part : PartsDropped(*before, study)) {
    dropped.insert(part.paths.begin(), part.paths.end());
  }
  v1::StudySpec missing;
  for (const v1::VariantSpec& variant : study.variants()) {
    int64_t pairs = PairsOf(study, variant);
    if (!dropped.contains(variant.name())) pairs -= PairsThereOf(out_dir + "/" + variant.name());
    if (pairs <= 0) continue;
    v1::VariantSpec& part = *missing.add_variants();
    *part.mutable_config() = variant.config();
    part.set_pairs(pairs);
  }
  return EstimateBytes(missing);
}

}  // namespace parallax::client
