// Bounds of a study that are not in a FieldRule of config.proto. Files, flags and RPCs all use
// these.
#pragma once

#include <cstddef>
#include <cstdint>

namespace parallax {

// Largest study, in bytes of its message with all defaults written out; 1,000 variants take about
// 1.2 MB.
inline constexpr size_t kMaxStudyBytes = 2 << 20;
// Largest scene config, and largest study file that is kept beside the dataset as it is, in bytes.
inline constexpr size_t kMaxYamlBytes = 512 << 10;
// Largest study file that is read, in bytes: the lock file of 1,000 variants has about 5 MB.
inline constexpr size_t kMaxStudyFileBytes = 16 << 20;
inline constexpr int kMaxVariants = 1000;
inline constexpr int64_t kMaxPairs = 100'000'000;  // Pairs of one variant.
inline constexpr int kMaxRigsPerScene = 1000;
inline constexpr int kMaxPriority = 1000;  // Priorities are in [-1000, 1000].
// The highest priority that a submitter gives its own studies; an operator may give more.
inline constexpr int kMostOwnPriority = 100;
inline constexpr int64_t kMaxMemoryMb = int64_t{1} << 30;
inline constexpr int kMaxTags = 64;
inline constexpr int kMaxSlots = 1024;
inline constexpr int64_t kMaxCores = 1 << 20;
// Largest image, in pixels: 8K UHD, which needs about 2 GB for all maps of both eyes.
inline constexpr int64_t kMaxPixels = 7680 * 4320;
// Longest text of a config, in bytes, and longest list or {choice: [...]}, in items.
inline constexpr size_t kMaxTextBytes = 1000;
inline constexpr int kMaxListItems = 1000;
// Most trainings of a study: training sets times seeds.
inline constexpr int64_t kMaxTrainings = 10'000;
// Most evaluations of a study: checkpoints of all trainings, plus baselines, times benchmarks.
inline constexpr int64_t kMaxEvaluations = 20'000;
// Most pairs of one training set. Their folders travel in one message, with at most about 100 bytes
// a pair.
inline constexpr int64_t kMaxTrainingPairs = 400'000;

}  // namespace parallax
