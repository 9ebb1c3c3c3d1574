#include "worker/dataset/verify/verify_light.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "common/config/frame_files.h"
#include "common/image/io.h"
#include "worker/dataset/frame/frame_reader.h"
#include "worker/dataset/frame/sensor_stage.h"
#include "worker/render/film/exposure.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kOthers = 1e-3;  // Part of an exposed picture's pixels that may be otherwise.
constexpr double kMeanSteps = 0.05;

class LightChecker {
 public:
  LightChecker(const DatasetFrame& frame, std::vector<Finding>& findings)
      : frame_(frame), findings_(findings) {}

  void Run() {
    const auto json = ReadFrameJson(frame_.dir);
    if (!json.ok()) return;  // CheckGeometry reports it.
    exposed_ = !SensorKeyOf(*json).empty();
    const bool kept =
        frame_.files.contains(kLinearFiles[0]) && frame_.files.contains(kLinearFiles[1]);
    if (exposed_ && !kept) {
      Find("sensor", "frame.json", "its pictures are a sensor's, but it keeps no linear ones");
    }
    if (!kept || !Read(kLinearFiles[0], &ReadExrRgb, light_[0]) ||
        !Read(kLinearFiles[1], &ReadExrRgb, light_[1])) {
      return;
    }
    for (size_t eye = 0; eye < 2; ++eye) CheckNumbers(light_[eye], kLinearFiles[eye]);
    CheckDark();
    SensorPictures expected{ToSrgb(light_[0], 1), ToSrgb(light_[1], 1)};
    if (exposed_) {
      absl::StatusOr<SensorPictures> repeated = RepeatSensor(*json, frame_.dir);
      if (!repeated.ok()) {
        return Find("sensor", "frame.json", std::string(ToStd(repeated.status().message())));
      }
      expected = *std::move(repeated);
    }
    Compare("left.png", expected.left);
    Compare("right.png", expected.right);
  }

 private:
  void Find(const char* check, const std::string& file, const std::string& message) {
    findings_.push_back({check, frame_.dir + "/" + file, message});
  }

  template <typename ImageType>
  bool Read(const std::string& file, absl::StatusOr<ImageType> (*read)(const std::string&),
            ImageType& image) {
    absl::StatusOr<ImageType> result = read(frame_.dir + "/" + file);
    if (result.ok()) {
      image = *std::move(result);
      return true;
    }
    Find("image", file, std::string(ToStd(result.status().message())));
    return false;
  }

  void CheckNumbers(const ImageF3& light, const std::string& file) {
    const auto bad = std::count_if(light.values().begin(), light.values().end(),
                                   [](float v) { return !std::isfinite(v) || v < 0; });
    if (bad > 0) {
      Find("finite", file, fmt::format("{} numbers that are not >= 0 and finite", bad));
    }
  }

  // Half floats round by less than a step; machines may round a sensor's sums differently.
  void Compare(const std::string& file, const ImageRgb8& expected) {
    ImageRgb8 seen;
    if (!Read(file, &ReadPngRgb8, seen)) return;
    if (seen.width() != expected.width() || seen.height() != expected.height()) {
      return Find("size", file, "is not of the size of the linear picture");
    }
    size_t others = 0, first = 0;
    for (size_t i = seen.values().size(); i-- > 0;) {
      if (std::abs(int{seen.values()[i]} - int{expected.values()[i]}) <= 1) continue;
      ++others;
      first = i;
    }
    const double tolerated = exposed_ ? kOthers * static_cast<double>(seen.values().size()) : 0;
    if (static_cast<double>(others) <= tolerated) return;
    const size_t width = 3 * static_cast<size_t>(seen.width());
    Find(exposed_ ? "sensor" : "hdr", file,
         fmt::format("{} values, the first at ({}, {}): {}, the linear picture gives {}", others,
                     first % width / 3, first / width, seen.values()[first],
                     expected.values()[first]));
  }

  // The verdict "dark" is the rendered picture's, which only the linear one still tells.
  void CheckDark() {
    const Json& line = frame_.line;
    if (!exposed_ || !line.contains("filters") || !line["filters"].contains("dark")) return;
    const double value = line["filters"]["dark"].value("value", -1.0);
    const ImageRgb8 left = ToSrgb(light_[0], 1);
    double sum = 0;
    for (const uint8_t v : left.values()) sum += v;
    const double mean = sum / static_cast<double>(left.values().size());
    if (std::abs(mean - value) <= kMeanSteps) return;
    Find("filters", kLinearFiles[0],
         fmt::format("\"dark\" judged a mean intensity of {:f}, it has {:f}", value, mean));
  }

  const DatasetFrame& frame_;
  std::vector<Finding>& findings_;
  bool exposed_ = false;
  ImageF3 light_[2];
};

}  // namespace

void CheckLight(const DatasetFrame& frame, std::vector<Finding>& findings) {
  LightChecker(frame, findings).Run();
}

}  // namespace parallax
