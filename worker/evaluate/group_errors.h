// Which objects and materials a network gets wrong: errors added up by class over the images of our
// own archives, as a file for spreadsheets and a picture.
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

// `group` is "class" or "material". Entries of at least `least_share` of the pixels, largest mean
// error first; the paper's figure leaves out what is rarer than 0.001. Errors: kNotFound when no
// evaluation has that group.
absl::StatusOr<std::vector<GroupError>> GroupErrors(const std::vector<Evaluation>& evaluations,
                                                    const std::string& group,
                                                    double least_share = 0.001);

// A line an entry: name, pixels, share, epe, bad-1, bad-2, bad-3, d1.
std::string GroupErrorsCsv(const std::vector<GroupError>& errors);

// Bars of the mean error; the share of pixels and of bad-2 in numbers. Errors: as WritePng.
absl::Status DrawGroupErrors(const std::vector<GroupError>& errors, const std::string& title,
                             const std::string& out_png);

}  // namespace parallax
