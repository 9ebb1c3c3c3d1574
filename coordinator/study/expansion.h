// Expands a study into scenes: decides which scenes a variant needs next, and when it must give up.
// Pure functions; thread-safe.
//
// A variant's scenes have the ordinals 0, 1, 2, ...; each gives `rigs_per_scene` pairs, except that
// the highest living one may give fewer. A scene that is rejected or lost is replaced by the next
// ordinal. The partial scene is topped up before a new one begins. Therefore a variant's final
// pairs depend only on which seeds were rejected, not on the order in which that became known:
// however calm or chaotic the run, the dataset is the same.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/study.pb.h"

namespace parallax {

// Checks the numbers on which it depends that the expansion ends: variants, their pairs and rigs.
// All other checks of a study are those of ValidateStudy (common/config), which every Submit passes
// first.
// Errors: kInvalidArgument that names the variant.
absl::Status CheckStudySpec(const v1::StudySpec& spec);

// Return the pairs and the rigs a scene that a variant asks for: its own numbers, or the study's.
inline int64_t PairsOf(const v1::StudySpec& study, const v1::VariantSpec& variant) {
  return variant.pairs() > 0 ? variant.pairs() : study.pairs();
}
inline int32_t RigsPerSceneOf(const v1::StudySpec& study, const v1::VariantSpec& variant) {
  return variant.rigs_per_scene() > 0 ? variant.rigs_per_scene() : study.rigs_per_scene();
}
// Returns the pairs of all variants together.
int64_t TotalPairsOf(const v1::StudySpec& study);

// A scene that is planned.
struct ScenePlan {
  uint32_t ordinal = 0;
  uint32_t rigs = 0;  // Number of pairs that it gives in all.
};

// The state of a variant's expansion.
struct VariantPlan {
  int64_t pairs_wanted = 0;
  int64_t pairs_planned = 0;  // Pairs of all scenes that are neither rejected nor lost.
  uint32_t rigs_per_scene = 1;
  uint32_t next_ordinal = 0;
  std::optional<ScenePlan> highest_living;  // Absent if it has lost pairs.
  int64_t scenes_open = 0;                  // Scenes with unfinished jobs.
  int64_t scenes_ahead = 0;                 // Bound on the number of open scenes.
};
// The next scenes of a variant.
struct Expansion {
  std::optional<ScenePlan> top_up;  // The highest living scene with its new number of rigs.
  std::vector<ScenePlan> scenes;    // New scenes.
};
// Returns the next scenes of a variant, at most `limit` with the topped-up one.
Expansion NextScenes(const VariantPlan& plan, int64_t limit);

// Outcomes of a variant's scenes since it was submitted or retried.
struct SceneTally {
  int64_t solved = 0;
  int64_t rejected = 0;
  int64_t lost = 0;  // Failed or quarantined.
  // Pairs that were made. Absent: not counted, so that only solves speak for the variant.
  std::optional<int64_t> pairs;
  std::string last_reason;  // Why the latest scene was rejected or lost; may be empty.
};
inline constexpr int64_t kGiveUpRejected = 50;
inline constexpr int64_t kGiveUpLost = 10;
inline constexpr int64_t kGiveUpLostAPair = 3;
// Returns the reason why the variant should stop taking new seeds; empty while it should continue.
// Because of this, a study whose config has no valid scene, or whose renders all fail, ends with a
// clear message instead of running for ever. The message ends with `last_reason`.
std::string GiveUpReason(const SceneTally& tally);

}  // namespace parallax
