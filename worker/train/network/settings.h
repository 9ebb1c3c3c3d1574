// Settings of a training run: everything except the data that decides the bytes of its checkpoints.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "common/base/status.h"

namespace parallax {

// Exit statuses of the program `trainer`, for whoever runs it.
enum class TrainerExit {
  kDone = 0,
  kFailed = 1,       // Data missing or broken, disk full, checkpoint of another run.
  kUsage = 2,        // Unknown option or value, pairs smaller than the crop.
  kNotFinite = 3,    // The loss became NaN or infinite.
  kOutOfMemory = 4,  // The batch does not fit.
  kStopped = 5,      // SIGTERM or SIGINT; a checkpoint of the last step was written.
};

// Bounds of the size at which a network predicts; see predictor.h.
inline constexpr int kNetworkWidth = 1280;     // Pixels.
inline constexpr int kNetworkDisparity = 384;  // Pixels.
// The first of two looks has this part of the size of a single look.
inline constexpr double kFirstLook = 0.71;
inline constexpr double kMostEnlarged = 2;
// A second look follows if it is larger than the first one by this factor.
inline constexpr double kLeastEnlarged = 1.1;

// Ranges of the random changes made to every training pair.
struct AugmentSettings {
  // The crop is enlarged by 2^U(scale_low, scale_high); each axis then by another 2^U(-stretch,
  // stretch).
  double scale_low = -0.4, scale_high = 0.4, stretch = 0.2;
  double flip_probability = 0.5;        // Mirror and swap the eyes.
  double colour_probability = 0.9;      // Brightness, contrast, saturation, hue, gamma.
  double asymmetric_probability = 0.3;  // The two eyes get colours of their own.
  double erase_probability = 0.5;  // One or two rectangles of the right image lose their content.
  double y_jitter_probability = 0.3;  // The right image is up to `y_jitter_px` too high or too low.
  int y_jitter_px = 1;
  double noise_probability = 0.5, noise_max = 0.03;   // Standard deviation, of a range of 1.
  double blur_probability = 0.25, blur_max_px = 1.0;  // Standard deviation.
};

// All settings of a run; each affects the bytes of its checkpoints.
struct TrainSettings {
  uint64_t seed = 1;
  int64_t steps = 1500;
  int batch = 2;
  int crop_height = 192, crop_width = 384;  // Multiples of 32.
  int threads = 2;                          // Part of the result: sums are split by thread.
  int max_disparity = 192;        // Pixels of the crop; truth beyond it is not trained on.
  double learning_rate = 1.0e-3;  // Peak of the one-cycle schedule.
  double weight_decay = 1.0e-5;
  double gradient_clip = 1.0;  // Norm of all gradients together.
  // Weights that predict are a moving average over about 1 / (1 - decay) steps.
  double average_decay = 0.99;
  double occluded_weight = 0.2;  // Loss of pixels that the right eye does not see, against 1.
  AugmentSettings augment;
};

// Checks the ranges of all settings. Errors: kInvalidArgument naming the setting, its value and
// what is allowed.
absl::Status CheckSettings(const TrainSettings& settings);

nlohmann::ordered_json ToJson(const TrainSettings& settings);

// Reads settings that ToJson has written. Errors: kDataLoss if a key is missing or of another type.
absl::StatusOr<TrainSettings> SettingsFromJson(const nlohmann::ordered_json& json);

// Returns the first key whose value differs, as "crop_width: 384, but 320"; empty when equal.
std::string DifferenceOf(const nlohmann::ordered_json& seen, const nlohmann::ordered_json& wanted);

// Returns the learning rate of `step` in [0, steps). It rises linearly for the first 5 % (at most
// 200 steps) from a 25th of the peak, then falls linearly to a 10,000th of it.   Source: Smith and
// Topin, "Super-convergence", 2018.
double LearningRate(const TrainSettings& settings, int64_t step);

}  // namespace parallax
