// The stage `finish` for an existing dataset folder: new verdicts and cards after networks have
// scored its frames. Renders nothing.
#pragma once

#include <map>
#include <string>

#include "common/base/status.h"
#include "parallax/v1/study.pb.h"
#include "worker/dataset/archive/archive_index.h"

namespace parallax {

struct JudgedVariant {
  int64_t frames = 0;
  int64_t passed = 0;     // Pass all filters.
  int64_t ambiguous = 0;  // Fail the filter `ambiguous`, and maybe others.
};

// Rewrites index.jsonl and the card of the variant in `dir`, each file atomically. `shares` are the
// frames' ambiguous_share; frames without one lose theirs. `variant` belongs to `study` and has the
// filters. The caller holds the folder's lock.
//
// Errors: kDataLoss for a malformed line of the index; those of JudgeAnew and WriteDatasetCard.
absl::StatusOr<JudgedVariant> JudgeVariant(const std::string& dir, const v1::StudySpec& study,
                                           const v1::VariantSpec& variant,
                                           const std::map<FrameId, double>& shares);

}  // namespace parallax
