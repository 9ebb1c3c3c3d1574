// Counts of a study's jobs, as the queue, the page and the client read them from its status.
#pragma once

#include <cstdint>
#include <string_view>

#include "parallax/v1/service.pb.h"

namespace parallax {

// Return how many jobs of a variant, or of all variants of a study, are in `state`, such as
// "READY". With a `kind`, count only jobs of that kind.
inline int64_t JobsInState(const v1::VariantStatus& variant, std::string_view state,
                           std::string_view kind = "") {
  int64_t jobs = 0;
  for (const v1::JobCount& count : variant.jobs()) {
    if (count.state() == state && (kind.empty() || count.kind() == kind)) jobs += count.jobs();
  }
  return jobs;
}
inline int64_t JobsInState(const v1::StudyStatus& study, std::string_view state) {
  int64_t jobs = 0;
  for (const v1::VariantStatus& variant : study.variants()) jobs += JobsInState(variant, state);
  return jobs;
}

}  // namespace parallax
