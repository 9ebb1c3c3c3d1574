// How a study becomes scenes: which scenes a variant needs next, and when it must give up. Pure
// functions; thread-safe.
//
// A variant's scenes are ordinals 0, 1, 2, ...; each gives `rigs_per_scene` pairs, only the highest
// living one may give fewer. A scene that is rejected or lost is replaced by the next ordinal.
// Because the partial scene is topped up before a new one begins, the pairs that a variant ends
// with depend on which seeds were rejected, not on the order in which that came to light: calm or
// chaotic, the dataset is the same.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/study.pb.h"

namespace parallax {

// The numbers that expansion relies on, so that it ends: variants, their pairs and rigs. Whether a
// study may be submitted is for ValidateStudy (common/config), which every Submit passes first.
// Errors: kInvalidArgument naming the variant.
absl::Status CheckStudySpec(const v1::StudySpec& spec);

// What a variant asks for: its own numbers, or the study's.
inline int64_t PairsOf(const v1::StudySpec& study, const v1::VariantSpec& variant) {
  return variant.pairs() > 0 ? variant.pairs() : study.pairs();
}
inline int32_t RigsPerSceneOf(const v1::StudySpec& study, const v1::VariantSpec& variant) {
  return variant.rigs_per_scene() > 0 ? variant.rigs_per_scene() : study.rigs_per_scene();
}
int64_t TotalPairsOf(const v1::StudySpec& study);

struct ScenePlan {
  uint32_t ordinal = 0;
  uint32_t rigs = 0;  // Pairs that it is to give in all.
};

// Where a variant stands.
struct VariantPlan {
  int64_t pairs_wanted = 0;
  int64_t pairs_planned = 0;  // Of all scenes that are neither rejected nor lost.
  uint32_t rigs_per_scene = 1;
  uint32_t next_ordinal = 0;
  std::optional<ScenePlan> highest_living;  // Of the scenes that have lost nothing.
  int64_t scenes_open = 0;                  // With unfinished jobs.
  int64_t scenes_ahead = 0;                 // How many may be open.
};
struct Expansion {
  std::optional<ScenePlan> top_up;  // The highest living scene with its new number of rigs.
  std::vector<ScenePlan> scenes;    // New ones.
};
// At most `limit` scenes, the topped-up one included.
Expansion NextScenes(const VariantPlan& plan, int64_t limit);

// What became of a variant's scenes since it was submitted or retried.
struct SceneTally {
  int64_t solved = 0;
  int64_t rejected = 0;
  int64_t lost = 0;  // Failed or quarantined.
};
inline constexpr int64_t kGiveUpRejected = 50;
inline constexpr int64_t kGiveUpLost = 10;
// Why the variant should stop taking new seeds; empty while it should go on. So a config without
// valid scenes ends with a clear problem rather than never.
std::string GiveUpReason(const SceneTally& tally);

}  // namespace parallax
