// The stage `finish` of a dataset folder that is there already: verdicts and cards made anew after
// networks have scored its frames. Nothing is rendered.
#pragma once

#include <map>
#include <string>

#include "common/base/status.h"
#include "parallax/v1/study.pb.h"
#include "worker/dataset/archive_index.h"

namespace parallax {

struct JudgedVariant {
  int64_t frames = 0;
  int64_t passed = 0;     // All filters.
  int64_t ambiguous = 0;  // Fail the filter of that name, and maybe others too.
};

// Writes index.jsonl and the card of the variant in `dir`, each file at once. `shares`
// are the frames' ambiguous_share; frames without one lose theirs. `variant` belongs to `study` and
// has the filters to judge by. The caller holds the folder's lock.
//
// Errors: kDataLoss for a line of the index that is not one; those of JudgeAnew and
// WriteDatasetCard.
absl::StatusOr<JudgedVariant> JudgeVariant(const std::string& dir, const v1::StudySpec& study,
                                           const v1::VariantSpec& variant,
                                           const std::map<FrameKey, double>& shares);

}  // namespace parallax
