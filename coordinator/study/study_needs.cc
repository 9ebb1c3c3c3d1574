#include "coordinator/study/study_needs.h"

#include <fmt/core.h>

namespace parallax {

std::string NeedsOf(const v1::StudyStatus& study, std::string_view what,
                    std::string_view begin_again) {
  switch (study.state()) {
    case v1::STUDY_STATE_PAUSED:
      return fmt::format("{} is paused: `parallax resume {}`", what, study.study_id());
    case v1::STUDY_STATE_CANCELLED:
      return fmt::format("{} (study {}) was cancelled: {}", what, study.study_id(), begin_again);
    case v1::STUDY_STATE_FAILED:
      for (const v1::VariantStatus& variant : study.variants()) {
        if (variant.problems().empty()) continue;
        return fmt::format("{} failed: `parallax retry {}` tries again: variant {}: {}", what,
                           study.study_id(), variant.name(), variant.problems(0).error());
      }
      return fmt::format("{} failed: `parallax retry {}` tries again", what, study.study_id());
    default:
      return "";
  }
}

}  // namespace parallax
