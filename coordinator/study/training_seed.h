// The seeds of a study's trainings. Pure.
#pragma once

#include <cstdint>

#include "parallax/v1/study.pb.h"

namespace parallax {

// Returns the seed of a training set's training `i`: `i` itself, so that trainings of all studies
// begin alike, unless the study's seed is 2^32 or more. Such seeds, as of a search's confirmation,
// have trainings of their own: from 100 on, which is the most trainings of a set, below 2^31.
inline uint64_t TrainingSeed(const v1::StudySpec& study, int i) {
  const uint64_t high = study.seed() >> 32;
  return (high == 0 ? 0 : 100 * (1 + high % 10'000'000)) + static_cast<uint64_t>(i);
}

}  // namespace parallax
