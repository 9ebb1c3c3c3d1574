#include "common/config/camera_text.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/config/config.h"

namespace parallax {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr size_t kMostNames = 4;  // Variants in front of one line.

std::string Number(double value) {
  return std::abs(value) >= 1000 ? fmt::format("{:.0f}", value) : fmt::format("{:.4g}", value);
}

std::string Range(double low, double high) {
  const std::string from = Number(low), to = Number(high);
  return from == to ? from : from + " to " + to;
}

double Fov_deg(double side_px, double focal_px) {
  return 2 * std::atan(side_px / 2 / focal_px) / kDegree;
}

double FocalOf(double fov_deg, double side_px) {
  return side_px / 2 / std::tan(fov_deg * kDegree / 2);
}

Support Scaled(const v1::Distribution& values, double scale) {
  const Support support = SupportOf(values);
  return {support.low * scale, support.high * scale};
}

}  // namespace

std::string DescribeCamera(const v1::RigConfig& rigs) {
  const v1::CameraConfig& camera = rigs.camera();
  const double width = rigs.width_px(), height = rigs.height_px();
  const double scale_x = camera.has_width_px() ? width / camera.width_px() : 1;
  const double scale_y = camera.has_height_px() ? height / camera.height_px() : 1;
  Support fx, fy, cx{width / 2, width / 2}, cy{height / 2, height / 2};
  if (camera.has_fx_px()) {
    fx = Scaled(camera.fx_px(), scale_x);
    fy = Scaled(camera.has_fy_px() ? camera.fy_px() : camera.fx_px(), scale_y);
  } else {
    const Support fov = SupportOf(rigs.horizontal_fov_deg());
    fx = {FocalOf(fov.high, width), FocalOf(fov.low, width)};
    fy = fx;
  }
  if (camera.has_cx_px()) cx = Scaled(camera.cx_px(), scale_x);
  if (camera.has_cy_px()) cy = Scaled(camera.cy_px(), scale_y);
  Support baseline = SupportOf(rigs.baseline_m());
  if (!rigs.baselines_m().empty()) {
    const auto [least, most] =
        std::minmax_element(rigs.baselines_m().begin(), rigs.baselines_m().end());
    baseline = {*least, *most};
  }
  const auto disparity = [&](double depth_m) {
    return Range(fx.low * baseline.low / depth_m, fx.high * baseline.high / depth_m);
  };
  return fmt::format(
      "{}x{} px, K fx {} fy {} cx {} cy {} px, field of view {} x {} deg, baseline {} m, "
      "disparity {} px at 1 m, {} px at 10 m",
      rigs.width_px(), rigs.height_px(), Range(fx.low, fx.high), Range(fy.low, fy.high),
      Range(cx.low, cx.high), Range(cy.low, cy.high),
      Range(Fov_deg(width, fx.high), Fov_deg(width, fx.low)),
      Range(Fov_deg(height, fy.high), Fov_deg(height, fy.low)), Range(baseline.low, baseline.high),
      disparity(1), disparity(10));
}

std::vector<std::string> DescribeCameras(const v1::StudySpec& study) {
  std::vector<std::pair<std::string, std::vector<std::string>>> cameras;
  for (const v1::VariantSpec& variant : study.variants()) {
    const std::string camera = DescribeCamera(variant.config().rigs());
    auto known = std::find_if(cameras.begin(), cameras.end(),
                              [&](const auto& other) { return other.first == camera; });
    if (known == cameras.end()) known = cameras.insert(cameras.end(), {camera, {}});
    known->second.push_back(variant.name());
  }
  std::vector<std::string> lines;
  for (const auto& [camera, variants] : cameras) {
    std::string names;
    for (size_t i = 0; i < std::min(variants.size(), kMostNames); ++i) {
      names += (i > 0 ? ", " : " of ") + variants[i];
    }
    if (variants.size() > kMostNames)
      names += fmt::format(" and {} more", variants.size() - kMostNames);
    lines.push_back("Camera" + (cameras.size() > 1 ? names : "") + ": " + camera);
  }
  return lines;
}

}  // namespace parallax
