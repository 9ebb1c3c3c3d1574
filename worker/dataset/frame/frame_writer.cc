#include "worker/dataset/frame/frame_writer.h"

#include <sys/stat.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <set>
#include <vector>

#include "common/base/hash.h"
#include "common/base/seconds.h"
#include "common/base/system/clock.h"
#include "common/base/system/file.h"
#include "common/config/frame_files.h"
#include "common/image/io.h"
#include "common/store/store.h"
#include "worker/dataset/frame/frame_json.h"
#include "worker/dataset/frame/frame_statistics.h"

namespace parallax {
namespace {

struct Output {
  std::string name;
  std::function<absl::StatusOr<std::string>()> encode;
};

absl::Status CheckSizes(const View& view, const v1::Rig& rig, const char* eye,
                        const std::set<std::string>& maps) {
  const auto fits = [&](const auto& image) {
    return image.width() == rig.width_px() && image.height() == rig.height_px();
  };
  const struct {
    const char* name;
    bool fits;
  } images[] = {{"image", fits(view.color)},
                {"depth", fits(view.depth_m)},
                {"disparity", fits(view.disparity_px)},
                {"occlusion", fits(view.occlusion)},
                {"objects", fits(view.objects)},
                {"materials", fits(view.materials)},
                {"normals", fits(view.normals)},
                {"masks", fits(view.masks)},
                {"exact_occlusion", !maps.count("exact_occlusion") || fits(view.exact_occlusion)},
                {"infrared", !maps.count("infrared") || fits(view.infrared)}};
  for (const auto& map : images) {
    if (map.fits) continue;
    return InvalidArgument("rig {}: {} {} is not {} x {}", rig.index(), eye, map.name,
                           rig.width_px(), rig.height_px());
  }
  return absl::OkStatus();
}

absl::Status CheckRawSizes(const RawView& view, const v1::RawCamera& camera,
                           const std::string& eye) {
  const auto fits = [&](const auto& image) {
    return !image.empty() && image.width() == camera.width_px() &&
           image.height() == camera.height_px();
  };
  if (fits(view.color) && fits(view.flow) && fits(view.occlusion)) return absl::OkStatus();
  return InvalidArgument("the raw {} picture is not {} x {}", eye, camera.width_px(),
                         camera.height_px());
}

void AddRawOutputs(const RawView& view, const std::string& eye, std::vector<Output>& outputs) {
  outputs.push_back({"raw_" + eye + ".png", [&view] { return EncodePng(view.color); }});
  outputs.push_back({"raw_flow_" + eye + ".exr", [&view] { return EncodeExrRgb(view.flow); }});
  outputs.push_back(
      {"raw_occlusion_" + eye + ".png", [&view] { return EncodePng(view.occlusion); }});
}

absl::Status AddFlowOutputs(const View& view, const v1::Rig& rig, const std::string& eye,
                            std::vector<Output>& outputs) {
  const std::pair<const char*, const FlowMaps*> directions[] = {{"forward", &view.forward},
                                                                {"backward", &view.backward}};
  for (const auto& [direction, maps] : directions) {
    if (maps->flow.width() != rig.width_px() || maps->flow.height() != rig.height_px() ||
        maps->occlusion.pixels() != maps->flow.pixels()) {
      return InvalidArgument("rig {}: the {} {} flow is not {} x {}", rig.index(), eye, direction,
                             rig.width_px(), rig.height_px());
    }
    const std::string name = std::string(direction) + "_" + eye;
    outputs.push_back(
        {"flow_" + name + ".exr", [maps = maps] { return EncodeExrRgb(maps->flow); }});
    outputs.push_back(
        {"flow_occlusion_" + name + ".png", [maps = maps] { return EncodePng(maps->occlusion); }});
  }
  return absl::OkStatus();
}

// Files of one eye; `eye` is "left" or "right".
void AddOutputs(const View& view, const std::string& eye, const std::set<std::string>& maps,
                std::vector<Output>& outputs) {
  outputs.push_back({eye + ".png", [&view] { return EncodePng(view.color); }});
  const auto add = [&](const std::string& map, const char* extension, auto encode) {
    if (maps.count(map)) outputs.push_back({map + "_" + eye + extension, encode});
  };
  add("depth", ".exr", [&view] { return EncodeExrY(view.depth_m); });
  add("disparity", ".exr", [&view] { return EncodeExrY(view.disparity_px); });
  add("occlusion", ".png", [&view] { return EncodePng(view.occlusion); });
  add("objects", ".png", [&view] { return EncodePng(view.objects); });
  add("materials", ".png", [&view] { return EncodePng(view.materials); });
  add("normals", ".exr", [&view] { return EncodeExrHalfRgb(view.normals); });
  add("masks", ".png", [&view] { return EncodePng(view.masks); });
  add("exact_occlusion", ".png", [&view] { return EncodePng(view.exact_occlusion); });
  add("infrared", ".png", [&view] { return EncodePng(view.infrared); });
}

// Encodes linear light with the exposure of the 8-bit picture, within the range of a half float.
absl::StatusOr<std::string> EncodeLight(const View& view, float exposure) {
  ImageF3 light = view.radiance;
  for (float& value : light.values()) {
    value = std::isfinite(value) ? std::clamp(value * exposure, 0.0f, kMostLight) : 0.0f;
  }
  return EncodeExrHalfRgb(light);
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
  const std::set<std::string> maps(job.render.maps().begin(), job.render.maps().end());
  RETURN_IF_ERROR(CheckSizes(job.frame.left, job.rig, "left", maps));
  RETURN_IF_ERROR(CheckSizes(job.frame.right, job.rig, "right", maps));
  const SteadyTime begin = Clock::System().Steady();
  const FrameStatistics statistics = ComputeStatistics(job.scene, job.frame);
  const double statistics_s = SecondsSince(begin);

  std::vector<Output> outputs;
  AddOutputs(job.frame.left, "left", maps, outputs);
  AddOutputs(job.frame.right, "right", maps, outputs);
  if (job.render.keep_hdr()) {
    const StereoFrame& frame = job.frame;
    outputs.push_back(
        {kLinearFiles[0], [&frame] { return EncodeLight(frame.left, frame.exposure); }});
    outputs.push_back(
        {kLinearFiles[1], [&frame] { return EncodeLight(frame.right, frame.exposure); }});
  }
  if (maps.count("raw")) {
    RETURN_IF_ERROR(CheckRawSizes(job.frame.raw_left, job.rig.raw_left(), "left"));
    RETURN_IF_ERROR(CheckRawSizes(job.frame.raw_right, job.rig.raw_right(), "right"));
    AddRawOutputs(job.frame.raw_left, "left", outputs);
    AddRawOutputs(job.frame.raw_right, "right", outputs);
  }
  if (maps.count("flow")) {
    RETURN_IF_ERROR(AddFlowOutputs(job.frame.left, job.rig, "left", outputs));
    RETURN_IF_ERROR(AddFlowOutputs(job.frame.right, job.rig, "right", outputs));
  }
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
  const FrameExposures exposures{double{job.frame.exposure}, double{job.frame.infrared_exposure}};
  ASSIGN_OR_RETURN(const std::string json,
                   FrameJson(job.scene, job.rig, exposures, statistics, job.render));
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
