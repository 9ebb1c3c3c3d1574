#include "worker/dataset/frame/frame_writer.h"

#include <sys/stat.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <vector>

#include "common/base/hash.h"
#include "common/base/seconds.h"
#include "common/base/system/clock.h"
#include "common/base/system/file.h"
#include "common/config/frame_files.h"
#include "common/config/frame_maps.h"
#include "common/image/io.h"
#include "common/store/store.h"
#include "worker/dataset/frame/frame_images.h"
#include "worker/dataset/frame/frame_json.h"
#include "worker/dataset/frame/frame_statistics.h"

namespace parallax {
namespace {

struct Output {
  std::string name;
  std::function<absl::StatusOr<std::string>()> encode;
};

// Refuses an image that is not of its camera's size.
absl::Status CheckSize(const FrameMap& row, const std::string& file, const FrameImage& image,
                       const v1::Rig& rig, bool is_left) {
  int width = rig.width_px(), height = rig.height_px();
  if (row.pass == "raw") {
    const v1::RawCamera& camera = is_left ? rig.raw_left() : rig.raw_right();
    width = camera.width_px(), height = camera.height_px();
  }
  const bool fits = std::visit(
      [&](const auto* seen) {
        return !seen->empty() && seen->width() == width && seen->height() == height;
      },
      image);
  if (fits) return absl::OkStatus();
  return InvalidArgument("rig {}: {} is not {} x {}", rig.index(), file, width, height);
}

// The files of all maps that the config asks for. The ground truth must be there in any case:
// statistics are computed from it.
absl::StatusOr<std::vector<Output>> OutputsOf(const FrameJob& job) {
  std::vector<Output> outputs;
  const std::map<std::string, FrameImage> images = ImagesOf(job.frame);
  for (const FrameMap& row : FrameMaps()) {
    const bool wanted = row.IsIn(job.render);
    if (!wanted && row.pass != "truth") continue;
    bool is_left = false;
    for (const std::string& file : row.Files()) {
      is_left = !is_left;
      const auto found = images.find(file);
      if (row.sparse && found == images.end()) continue;
      if (found == images.end()) return Internal("no pass makes {}", file);
      RETURN_IF_ERROR(CheckSize(row, file, found->second, job.rig, is_left));
      if (!wanted) continue;
      if (row.map == FrameMap::kKeepHdr) {
        const View& view = is_left ? job.frame.left : job.frame.right;
        outputs.push_back(
            {file, [&] { return EncodeExrHalfRgb(LightOf(view, job.frame.exposure)); }});
      } else {
        outputs.push_back({file, [&row, image = found->second] { return EncodeMap(row, image); }});
      }
    }
  }
  return outputs;
}

absl::Status MakeEmptyFolder(const std::string& dir) {
  std::error_code error;
  std::filesystem::remove_all(dir, error);
  if (!error) std::filesystem::create_directories(dir, error);
  return error ? ErrnoError(error.value(), "make folder " + dir) : absl::OkStatus();
}

// Writes a file durably and makes it read-only, because published files never change.
absl::StatusOr<v1::FileEntry> WriteEntry(const std::string& dir, const std::string& name,
                                         const std::string& bytes) {
  const std::string path = dir + "/" + name;
  RETURN_IF_ERROR(WriteFile(path, bytes, /*sync=*/true));
  ::chmod(path.c_str(), 0444);
  v1::FileEntry entry;
  entry.set_name(name);
  entry.set_size(static_cast<int64_t>(bytes.size()));
  entry.set_sha256(Sha256Hex(bytes));
  return entry;
}

}  // namespace

absl::StatusOr<v1::FrameResult> WriteFrame(const FrameJob& job) {
  ASSIGN_OR_RETURN(const std::vector<Output> outputs, OutputsOf(job));
  const SteadyTime begin = Clock::System().Steady();
  const FrameStatistics statistics = ComputeStatistics(job.scene, job.frame);
  const double statistics_s = SecondsSince(begin);
  RETURN_IF_ERROR(MakeEmptyFolder(job.dir));

  std::vector<absl::StatusOr<v1::FileEntry>> entries(outputs.size(), v1::FileEntry());
  tbb::parallel_for(size_t{0}, outputs.size(), [&](size_t i) {
    if (job.cancel.cancelled()) {
      entries[i] = Cancelled("while writing the frame");
      return;
    }
    const absl::StatusOr<std::string> bytes = outputs[i].encode();
    entries[i] = bytes.ok()
                     ? WriteEntry(job.dir, outputs[i].name, *bytes)
                     : absl::StatusOr<v1::FileEntry>(WithContext(bytes.status(), outputs[i].name));
  });

  v1::FrameResult result;
  for (const absl::StatusOr<v1::FileEntry>& entry : entries) {
    RETURN_IF_ERROR(entry.status());
    *result.add_files() = *entry;
  }
  ASSIGN_OR_RETURN(const std::string json,
                   FrameJson(job.scene, job.rig, job.frame, statistics, job.render));
  ASSIGN_OR_RETURN(*result.add_files(), WriteEntry(job.dir, "frame.json", json));
  RETURN_IF_ERROR(SyncPath(job.dir));

  std::sort(result.mutable_files()->begin(), result.mutable_files()->end(),
            [](const auto& a, const auto& b) { return a.name() < b.name(); });
  result.set_rig(job.rig.index());
  result.set_path(job.store_path);
  for (const auto& [name, value] : StatisticsByName(statistics)) {
    (*result.mutable_statistics())[name] = value;
  }
  auto& stage_s = *result.mutable_stage_s();
  stage_s["cache"] = job.frame.cache_s;
  stage_s["trace"] = job.frame.trace_s;
  stage_s["denoise"] = job.frame.denoise_s;
  stage_s["truth"] = job.frame.truth_s;
  stage_s["statistics"] = statistics_s;
  stage_s["write"] = SecondsSince(begin) - statistics_s;
  return result;
}

}  // namespace parallax
