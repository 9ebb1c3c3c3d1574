#include "worker/dataset/verify/verify_filters.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "worker/dataset/frame/frame_statistics.h"
#include "worker/dataset/frame/sensor_stage.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

void CompareNearest(const CheckedFrame& frame, const std::string& name, double value) {
  if (frame.eyes[0].depth.empty() || frame.eyes[1].depth.empty()) return;
  double nearest = 0;
  for (const CheckedEye& eye : frame.eyes) {
    for (const float z : eye.depth.values()) {
      if (z > 0 && (nearest == 0 || double{z} < nearest)) nearest = double{z};
    }
  }
  if (std::abs(nearest - value) > 1e-6 * nearest) {
    frame.Find("filters", "",
               fmt::format("\"{}\" judged a nearest depth of {:.9g} m, the maps have {:.9g}", name,
                           value, nearest));
  }
}

// The maps can't tell a network's score, so the verdict is compared with the index's statistics.
void CompareShare(const CheckedFrame& frame, double value) {
  const Json share =
      frame.index.line.value("statistics", Json::object()).value("ambiguous_share", Json());
  if (share.is_number() && share.get<double>() == value && value >= 0 && value <= 1) return;
  frame.Find("filters", "",
             fmt::format("\"ambiguous\" judged a share of {:.9g}, the statistics have {}", value,
                         share.dump()));
}

void CompareTexture(const CheckedFrame& frame, double value) {
  const CheckedEye& left = frame.eyes[0];
  if (left.color.empty() || left.depth.empty() || !SensorKeyOf(frame.json).empty()) return;
  const double share = TexturedFraction(left.color, left.depth);
  if (std::abs(share - value) <= 1e-9) return;
  frame.Find(
      "filters", "",
      fmt::format("\"textureless\" judged a share of {:.9g}, the maps have {:.9g}", value, share));
}

void CompareEmpty(const CheckedFrame& frame, double value) {
  const auto& depth = frame.eyes[0].depth;
  if (depth.empty()) return;
  const auto sky = std::count_if(depth.values().begin(), depth.values().end(),
                                 [](float depth_m) { return !(depth_m > 0); });
  const double share = static_cast<double>(sky) / static_cast<double>(depth.values().size());
  if (std::abs(share - value) <= 1e-9) return;
  frame.Find("filters", "",
             fmt::format("\"empty\" judged a share of {:.9g}, the maps have {:.9g}", value, share));
}

void CompareMean(const CheckedFrame& frame, double value) {
  const ImageRgb8& image = frame.eyes[0].color;
  // A sensor's picture is not what the filter judged: CheckLight compares it.
  if (image.empty() || !SensorKeyOf(frame.json).empty()) return;
  double sum = 0;
  for (const uint8_t v : image.values()) sum += v;
  const double mean = sum / static_cast<double>(image.values().size());
  if (std::abs(mean - value) <= 1e-6 * std::max(1.0, mean)) return;
  frame.Find(
      "filters", "",
      fmt::format("\"dark\" judged a mean intensity of {:.9g}, left.png has {:.9g}", value, mean));
}

// Checks one filter's verdict. Returns whether the frame passed it.
bool CheckVerdict(const CheckedFrame& frame, const std::string& name, const Json& verdict) {
  const double value = verdict["value"], threshold = verdict["threshold"];
  const bool passed = verdict["passed"];
  const bool is_distance = name == "near" || name == "close";
  const bool has_most = name == "ambiguous" || name == "empty";
  const bool expected =
      has_most ? value <= threshold : value >= threshold || (is_distance && value == 0);
  if (passed != expected) {
    frame.Find("filters", "",
               fmt::format("\"{}\" {} with {:.9g}, its threshold is {:.9g}", name,
                           expected ? "failed" : "passed", value, threshold));
  }
  if (is_distance) CompareNearest(frame, name, value);
  if (name == "dark") CompareMean(frame, value);
  if (name == "textureless") CompareTexture(frame, value);
  if (name == "empty") CompareEmpty(frame, value);
  if (name == "ambiguous") CompareShare(frame, value);
  return passed;
}

}  // namespace

void CheckFilters(const CheckedFrame& frame) {
  const Json& line = frame.index.line;
  bool passed = true;
  if (line.contains("filters") && line["filters"].is_object()) {
    for (const auto& [name, verdict] : line["filters"].items()) {
      if (!verdict.is_object() || !verdict.contains("passed") || !verdict.contains("value") ||
          !verdict.contains("threshold")) {
        frame.Find("filters", "",
                   "the verdict of \"" + name + "\" lacks passed, value or threshold");
        continue;
      }
      passed = CheckVerdict(frame, name, verdict) && passed;
    }
  } else {
    frame.Find("filters", "", "the index has no filter verdicts for it");
  }
  if (frame.index.passed != passed) frame.Find("filters", "", "passed contradicts the verdicts");
}

}  // namespace parallax
