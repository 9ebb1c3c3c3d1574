// The trainings and evaluations of a study: its training sets, and the variant that is held out.
// Pure functions of a study that passes ValidateStudy; thread-safe.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "parallax/v1/study.pb.h"

namespace parallax {

// Name of the variant that `evaluate.heldout_pairs` adds to a study, and of the benchmark made of
// it. No other variant may have this name.
inline constexpr char kHeldoutName[] = "heldout";

// Folders that a dataset has beside its variants where networks are trained or scored. No variant
// of a study with `train` or `evaluate` may have one of these names.
inline constexpr std::string_view kResultFolders[] = {"training", "scores", "sheets", "curves",
                                                      "errors"};

// Returns the seed from which a variant's scenes are drawn: its own, or the study's.
inline uint64_t SeedOf(const v1::StudySpec& study, const v1::VariantSpec& variant) {
  return variant.seed() != 0 ? variant.seed() : study.seed();
}

// Returns whether the study holds out a variant for a benchmark of its own.
inline bool WantsHeldout(const v1::StudySpec& study) {
  return study.evaluate().heldout_pairs() > 0;
}

// Fills in the defaults of `train` and `evaluate` if the study has them, and appends or replaces
// the held-out variant. It has the parameters of `evaluate.heldout_variant` and a seed that follows
// from the study's and differs from all other variants'. Lists stay as they are. Idempotent.
void ResolveTraining(v1::StudySpec* study);

// Returns the training sets in order: each variant as a mixture of one part, then the mixtures.
// Empty without `train`. Requires a resolved study. Each has its truth, "first" or "behind".
std::vector<v1::Mixture> TrainingSetsOf(const v1::StudySpec& study);

// Returns the share of the set's pairs whose right images belong to other pairs, 0 to 1. Requires a
// resolved study.
double MismatchedShareOf(const v1::Mixture& set);

// Returns which surface networks are scored on in held-out pairs, "first" or "behind"; empty
// without `train` unless `evaluate` says. Requires a resolved study.
std::string TruthOfHeldout(const v1::StudySpec& study);

// Returns the index in `sets` of the set with the same parts as `curated` but without curation,
// whose networks score the frames. -1: none exists.
int PlainTwinOf(const v1::Mixture& curated, const std::vector<v1::Mixture>& sets);

}  // namespace parallax
