// Errors of a network by class of object or material, summed over the images of our own archives,
// as CSV and as a picture.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "worker/evaluate/scores.h"

namespace parallax {

// The errors of one class or material.
struct GroupError {
  std::string name;
  double share = 0;  // Part of all pixels with truth in [0, 1].
  ErrorTally tally;  // All pixels of all images and evaluations together.
};

// Adds up the errors by `group`, which is "class" or "material". Returns the entries with at least
// `least_share` of the pixels, the largest mean error first; the paper's figure leaves out what is
// rarer than 0.001. Errors: kNotFound when no evaluation has that group.
absl::StatusOr<std::vector<GroupError>> GroupErrors(const std::vector<Evaluation>& evaluations,
                                                    const std::string& group,
                                                    double least_share = 0.001);

// Returns the entries as CSV, one line each: name, pixels, share, epe, bad-1, bad-2, bad-3, d1.
std::string GroupErrorsCsv(const std::vector<GroupError>& errors);

// Draws the mean errors as bars, with the share of pixels and bad-2 as numbers. Errors: those of
// WritePng.
absl::Status DrawGroupErrors(const std::vector<GroupError>& errors, const std::string& title,
                             const std::string& out_png);

}  // namespace parallax
