#include "common/config/verdicts.h"

#include <optional>

namespace parallax {
namespace {

// Empty when the filters do not ask for the verdict. Judge fills in the name.
using Opinion = absl::StatusOr<std::optional<Verdict>>;

absl::StatusOr<double> Statistic(const FrameFacts& frame, const std::string& name) {
  const auto found = frame.statistics.find(name);
  if (found != frame.statistics.end()) return found->second;
  return FailedPrecondition(
      "there is no statistic \"{}\": an older version made the frame; make the dataset again in "
      "another folder",
      name);
}

Opinion Dark(const FrameFacts& frame, const v1::FilterConfig& filters) {
  ASSIGN_OR_RETURN(const double mean, Statistic(frame, "mean_intensity"));
  const double least = filters.min_mean_intensity();
  return Verdict{.passed = mean >= least, .value = mean, .threshold = least};
}

Opinion NearestIsAtLeast(const FrameFacts& frame, double least) {
  ASSIGN_OR_RETURN(const double nearest, Statistic(frame, "min_depth_m"));
  return Verdict{.passed = nearest == 0 || nearest >= least, .value = nearest, .threshold = least};
}

Opinion Near(const FrameFacts& frame, const v1::FilterConfig& filters) {
  return NearestIsAtLeast(frame, filters.min_depth_m());
}

Opinion Close(const FrameFacts& frame, const v1::FilterConfig& filters) {
  if (filters.min_distance_m() == 0) return std::nullopt;
  return NearestIsAtLeast(frame, filters.min_distance_m());
}

Opinion Textureless(const FrameFacts& frame, const v1::FilterConfig& filters) {
  const double least = filters.min_textured_fraction();
  if (least == 0) return std::nullopt;
  ASSIGN_OR_RETURN(const double share, Statistic(frame, "textured_fraction"));
  return Verdict{.passed = share >= least, .value = share, .threshold = least};
}

Opinion Empty(const FrameFacts& frame, const v1::FilterConfig& filters) {
  const double most = filters.has_max_empty_share() ? filters.max_empty_share() : 1;
  if (most >= 1) return std::nullopt;
  ASSIGN_OR_RETURN(const double share, Statistic(frame, "sky_fraction"));
  return Verdict{.passed = share <= most, .value = share, .threshold = most};
}

Opinion Ambiguous(const FrameFacts& frame, const v1::FilterConfig& filters) {
  const double most = filters.has_max_ambiguous_share() ? filters.max_ambiguous_share() : 1;
  const auto share = frame.statistics.find(kAmbiguousShare);
  if (most >= 1 || share == frame.statistics.end()) return std::nullopt;
  return Verdict{.passed = share->second <= most, .value = share->second, .threshold = most};
}

constexpr struct {
  const char* name;
  Opinion (*judge)(const FrameFacts& frame, const v1::FilterConfig& filters);
} kVerdicts[] = {
    {"dark", &Dark},    //
    {"near", &Near},    //
    {"close", &Close},  //
    {"textureless", &Textureless},
    {"ambiguous", &Ambiguous},
    {"empty", &Empty},
};

}  // namespace

absl::StatusOr<std::vector<Verdict>> Judge(const FrameFacts& frame,
                                           const v1::FilterConfig& filters) {
  std::vector<Verdict> verdicts;
  for (const auto& [name, judge] : kVerdicts) {
    Opinion opinion = judge(frame, filters);
    if (!opinion.ok()) return WithContext(opinion.status(), std::string("filter ") + name);
    if (!*opinion) continue;
    (*opinion)->name = name;
    verdicts.push_back(**std::move(opinion));
  }
  return verdicts;
}

}  // namespace parallax
