// The stage `finish`: judges a frame by its stored statistics. Verdicts are made when an archive is
// written or a stream delivers, and again when the study's filters change; none renders anything.
//
// To add a verdict, write its function in verdicts.cc and name it in kVerdicts there.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/config.pb.h"

namespace parallax {

// The statistic behind the verdict `ambiguous`, in a line of the index. Only curation writes it.
inline constexpr char kAmbiguousShare[] = "ambiguous_share";

// The outcome of one filter: the frame's value against the threshold.
struct Verdict {
  std::string name;
  bool passed = true;
  double value = 0;
  double threshold = 0;
};

// All facts by which a frame is judged.
struct FrameFacts {
  std::map<std::string, double> statistics;  // StatisticsByName, as the index keeps them.
};

// Returns the verdicts that `filters` ask for, in this order:
//   dark         mean_intensity is below min_mean_intensity
//   near         min_depth_m is below min_depth_m of the filters
//   close        the same with min_distance_m, unless that is 0
//   textureless  textured_fraction is below min_textured_fraction, unless that is 0
//   ambiguous    ambiguous_share is above max_ambiguous_share, unless that is 1 or absent;
//                frames without curation are not judged
//   empty        sky_fraction is above max_empty_share, unless that is 1 or absent
// A frame that sees no surface at all passes "near" and "close". Errors: kFailedPrecondition when
// the facts lack a number that a verdict needs, naming both.
absl::StatusOr<std::vector<Verdict>> Judge(const FrameFacts& frame,
                                           const v1::FilterConfig& filters);

}  // namespace parallax
