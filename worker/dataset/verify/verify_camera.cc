#include "worker/dataset/verify/verify_camera.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "common/config/config.h"
#include "worker/dataset/frame/frame_reader.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kCameraTolerance = 1e-6;  // Relative.

// The range in which a number of frame.json must lie.
struct Wanted {
  const char* name;
  double low, high;
};

// The range of `distribution` times `scale`; without it `otherwise` alone.
Wanted WantedOf(const char* name, bool given, const v1::Distribution& distribution, double scale,
                double otherwise) {
  if (!given) return {name, otherwise, otherwise};
  const Support support = SupportOf(distribution);
  return {name, support.low * scale, support.high * scale};
}

std::vector<Wanted> WantedIntrinsics(const v1::RigConfig& rigs) {
  const v1::CameraConfig& camera = rigs.camera();
  const double width = rigs.width_px(), height = rigs.height_px();
  const bool sized = camera.has_width_px() && camera.has_height_px();
  const double x = sized ? width / camera.width_px() : 1;
  const double y = sized ? height / camera.height_px() : 1;
  std::vector<Wanted> wanted = {
      {"width", width, width},
      {"height", height, height},
      WantedOf("cx", camera.has_cx_px(), camera.cx_px(), x, width / 2),
      WantedOf("cy", camera.has_cy_px(), camera.cy_px(), y, height / 2),
  };
  if (!camera.has_fx_px()) return wanted;  // As rigs.horizontal_fov_deg says.
  wanted.push_back(WantedOf("fx", true, camera.fx_px(), x, 0));
  const bool own = camera.has_fy_px();
  wanted.push_back(WantedOf("fy", true, own ? camera.fy_px() : camera.fx_px(), y, 0));
  return wanted;
}

Wanted WantedBaseline(const v1::RigConfig& rigs) {
  const auto& several = rigs.baselines_m();
  if (several.empty())
    return WantedOf("baseline_m", rigs.has_baseline_m(), rigs.baseline_m(), 1, 0);
  const auto [low, high] = std::minmax_element(several.begin(), several.end());
  return {"baseline_m", *low, *high};
}

}  // namespace

std::vector<Finding> CheckCameras(const DatasetVariant& variant, const v1::SceneConfig& config) {
  std::vector<Finding> findings;
  if (!config.rigs().has_camera()) return findings;
  const std::vector<Wanted> intrinsics = WantedIntrinsics(config.rigs());
  const Wanted baseline = WantedBaseline(config.rigs());
  for (const DatasetFrame& frame : variant.frames) {
    const absl::StatusOr<Json> json = ReadFrameJson(frame.dir);
    if (!json.ok()) continue;  // CheckGeometry reports it.
    const auto check = [&](const Json& in, const Wanted& wanted) {
      const double seen = in.value(wanted.name, std::nan(""));
      const double slack = kCameraTolerance * std::max(1.0, std::abs(wanted.high));
      if (seen >= wanted.low - slack && seen <= wanted.high + slack) return;
      findings.push_back(
          {"camera", frame.dir + "/frame.json",
           fmt::format("{} is {:.9g}, the study wants {:.9g}{}", wanted.name, seen, wanted.low,
                       wanted.low < wanted.high ? fmt::format(" to {:.9g}", wanted.high) : "")});
    };
    try {
      for (const Wanted& wanted : intrinsics) check(json->at("intrinsics"), wanted);
      check(*json, baseline);
    } catch (const Json::exception&) {
      continue;  // CheckGeometry reports it.
    }
  }
  return findings;
}

}  // namespace parallax
