// The studies that a search is made of: one for each rung, and one for the confirmation. Pure and
// thread-safe.
//
// All rungs have the search's seed, so that trials differ by their values only, and a rung's first
// scenes are those of the rung before, whose pairs are taken over by their keys.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/search.pb.h"

namespace parallax {

// Name of the built-in sampler.
inline constexpr char kSobolSampler[] = "sobol";
// Name of the default among the variants of a rung.
inline constexpr char kDefaultTrial[] = "default";

// Returns the search's settings with the defaults of those that are absent.
v1::SearchSpec SearchOf(const v1::StudySpec& search);
// Returns the variant that trials are compared with: the first that is not held out. Requires that
// there is one.
const v1::VariantSpec& DefaultOf(const v1::StudySpec& search);
// Returns the name of a trial's variant: "default", "trial-001".
std::string TrialName(int number);

// Checks what the rules of ValidateStudy leave to the coordinator, which all others have passed.
// Errors: kInvalidArgument that names the field.
absl::Status CheckSearch(const v1::StudySpec& search);

// Returns how many trials are proposed at once: all at Sobol's points; a quarter of them, 4 at
// least, where a sampler proposes the others by what the first ones have shown.
int TrialsAtOnce(const v1::StudySpec& search);

// Returns the benchmarks whose mean error is made small: those that the study names for it; else
// all that the confirmation does not have; the held-out pairs only if there is no other. And those
// of the confirmation.
std::vector<std::string> SearchedBenchmarks(const v1::StudySpec& search);
std::vector<std::string> ConfirmedBenchmarks(const v1::StudySpec& search);

// Returns the pairs of each variant on a rung: whole scenes, at least one. And the trainings.
int64_t PairsOfRung(const v1::StudySpec& search, int rung);
int32_t SeedsOfRung(const v1::StudySpec& search, int rung);
// Returns the share of the steps of a training.
double StepsOfRung(const v1::StudySpec& search, int rung);

// Returns the study of a rung, with a variant for each of the trials. Errors: kInvalidArgument if
// the values of a trial make no valid config, naming it.
absl::StatusOr<v1::StudySpec> RungStudy(const v1::StudySpec& search, int rung,
                                        const std::vector<v1::SearchTrial>& trials);
// Returns the study that confirms a trial: it and the default, with scenes and trainings of other
// seeds than any rung's, on the benchmarks of the confirmation. Errors: as RungStudy.
absl::StatusOr<v1::StudySpec> ConfirmStudy(const v1::StudySpec& search,
                                           const v1::SearchTrial& best);

}  // namespace parallax
