// What a study trains and evaluates: its training sets, and the variant that is held out. Pure
// functions of a study that passes ValidateStudy; thread-safe.
#pragma once

#include <cstdint>
#include <vector>

#include "parallax/v1/study.pb.h"

namespace parallax {

// Name of the variant that `evaluate.heldout_pairs` adds to a study, and of the benchmark that it
// makes. No other variant may have it.
inline constexpr char kHeldoutName[] = "heldout";

// The seed that a variant's scenes are drawn from: its own, or the study's.
inline uint64_t SeedOf(const v1::StudySpec& study, const v1::VariantSpec& variant) {
  return variant.seed() != 0 ? variant.seed() : study.seed();
}

inline bool WantsHeldout(const v1::StudySpec& study) {
  return study.evaluate().heldout_pairs() > 0;
}

// Fills in the defaults of `train` and `evaluate` where a study has them, and appends the variant
// that is held out, or makes it anew: the parameters of `evaluate.heldout_variant`, and a seed that
// follows from the study's and that no other variant has. Lists stay as they are. Doing it again
// changes nothing.
void ResolveTraining(v1::StudySpec* study);

// The training sets in order: variants by themselves as mixtures of one part, then the mixtures.
// Empty without `train`. Requires a resolved study.
std::vector<v1::Mixture> TrainingSetsOf(const v1::StudySpec& study);

// The place in `sets` of the set that `curated` is without curation: its networks score the frames.
// -1: there is none.
int PlainTwinOf(const v1::Mixture& curated, const std::vector<v1::Mixture>& sets);

}  // namespace parallax
