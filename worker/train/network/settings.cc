#include "worker/train/network/settings.h"

#include <algorithm>

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

// Calls `field(key, member)` for every setting, so that reading and writing know the same ones.
template <typename Settings, typename Field>
void ForEachField(Settings& s, Field field) {
  field("seed", s.seed);
  field("steps", s.steps);
  field("batch", s.batch);
  field("crop_height", s.crop_height);
  field("crop_width", s.crop_width);
  field("threads", s.threads);
  field("max_disparity", s.max_disparity);
  field("learning_rate", s.learning_rate);
  field("weight_decay", s.weight_decay);
  field("gradient_clip", s.gradient_clip);
  field("average_decay", s.average_decay);
  field("occluded_weight", s.occluded_weight);
  field("scale_low", s.augment.scale_low);
  field("scale_high", s.augment.scale_high);
  field("stretch", s.augment.stretch);
  field("flip_probability", s.augment.flip_probability);
  field("colour_probability", s.augment.colour_probability);
  field("asymmetric_probability", s.augment.asymmetric_probability);
  field("erase_probability", s.augment.erase_probability);
  field("y_jitter_probability", s.augment.y_jitter_probability);
  field("y_jitter_px", s.augment.y_jitter_px);
  field("noise_probability", s.augment.noise_probability);
  field("noise_max", s.augment.noise_max);
  field("blur_probability", s.augment.blur_probability);
  field("blur_max_px", s.augment.blur_max_px);
}

absl::Status Refuse(const std::string& name, const std::string& seen, const std::string& wanted) {
  return InvalidArgument("{} is {}, but must be {}", name, seen, wanted);
}

}  // namespace

absl::Status CheckSettings(const TrainSettings& s) {
  const auto range = [](const char* name, double value, double low, double high) {
    if (value >= low && value <= high) return absl::OkStatus();
    return Refuse(name, Json(value).dump(),
                  "between " + Json(low).dump() + " and " + Json(high).dump());
  };
  RETURN_IF_ERROR(range("steps", static_cast<double>(s.steps), 1, 1e8));
  RETURN_IF_ERROR(range("batch", s.batch, 1, 256));
  RETURN_IF_ERROR(range("threads", s.threads, 1, 1024));
  RETURN_IF_ERROR(range("learning rate", s.learning_rate, 0, 1));
  RETURN_IF_ERROR(range("crop height", s.crop_height, 32, 8192));
  RETURN_IF_ERROR(range("crop width", s.crop_width, 32, 8192));
  RETURN_IF_ERROR(range("max disparity", s.max_disparity, 32, 1024));
  RETURN_IF_ERROR(range("scale", s.augment.scale_low, -4, s.augment.scale_high));
  RETURN_IF_ERROR(range("scale", s.augment.scale_high, s.augment.scale_low, 4));
  for (const auto& [name, value] : {std::pair("crop height", s.crop_height),
                                    {"crop width", s.crop_width},
                                    {"max disparity", s.max_disparity}}) {
    if (value % 32 != 0) return Refuse(name, std::to_string(value), "a multiple of 32");
  }
  return absl::OkStatus();
}

Json ToJson(const TrainSettings& settings) {
  Json json;
  ForEachField(settings, [&](const char* key, const auto& value) { json[key] = value; });
  return json;
}

absl::StatusOr<TrainSettings> SettingsFromJson(const Json& json) {
  TrainSettings settings;
  std::string missing;
  ForEachField(settings, [&](const char* key, auto& value) {
    if (json.is_object() && json.contains(key) && json[key].is_number()) {
      json[key].get_to(value);
    } else if (missing.empty()) {
      missing = key;
    }
  });
  if (missing.empty()) return settings;
  return DataLoss("the settings lack the number \"{}\"", missing);
}

std::string DifferenceOf(const Json& seen, const Json& wanted) {
  for (const auto& [key, value] : wanted.items()) {
    const Json other = seen.contains(key) ? seen[key] : Json();
    if (other != value) return key + ": " + other.dump() + ", but " + value.dump();
  }
  return "";
}

double LearningRate(const TrainSettings& settings, int64_t step) {
  const auto steps = static_cast<double>(settings.steps);
  const double warm = std::clamp(0.05 * steps, 1.0, 200.0);
  const auto at = static_cast<double>(step);
  if (at < warm) return settings.learning_rate * (0.04 + 0.96 * at / warm);
  const double left = (steps - at) / std::max(1.0, steps - warm);
  return settings.learning_rate * std::max(1e-4, left);
}

}  // namespace parallax
