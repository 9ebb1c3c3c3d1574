// Bounds of a study that no FieldRule of config.proto states. One place for file, flag and RPC.
#pragma once

#include <cstddef>
#include <cstdint>

namespace parallax {

// A study as a message, defaults written out: 1,000 variants have about 1.2 MB.
inline constexpr size_t kMaxStudyBytes = 2 << 20;
// A study file or scene config; it is kept beside the dataset.
inline constexpr size_t kMaxYamlBytes = 512 << 10;
inline constexpr int kMaxVariants = 1000;
inline constexpr int64_t kMaxPairs = 100'000'000;  // Pairs of one variant.
inline constexpr int kMaxRigsPerScene = 1000;
inline constexpr int kMaxPriority = 1000;  // And as much below 0.
inline constexpr int64_t kMaxMemoryMb = int64_t{1} << 30;
inline constexpr int kMaxTags = 64;
inline constexpr int kMaxSlots = 1024;
inline constexpr int64_t kMaxCores = 1 << 20;
// Pixels of one image: 8K UHD, which takes some 2 GB for all maps of both eyes.
inline constexpr int64_t kMaxPixels = 7680 * 4320;
// Texts of a config, lists of a config, values of {choice: [...]}.
inline constexpr size_t kMaxTextBytes = 1000;
inline constexpr int kMaxListItems = 1000;
// Trainings of a study: training sets times seeds.
inline constexpr int64_t kMaxTrainings = 10'000;
// Evaluations of a study: checkpoints of all trainings, and baselines, times benchmarks.
inline constexpr int64_t kMaxEvaluations = 20'000;
// Pairs of one training set, whose folders travel in one message: at most about 100 bytes a pair.
inline constexpr int64_t kMaxTrainingPairs = 400'000;

}  // namespace parallax
