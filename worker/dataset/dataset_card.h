// Describes a dataset for programs (dataset.json, croissant.json) and for people (README.md,
// LICENSE).
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/study.pb.h"
#include "worker/dataset/archive_index.h"

namespace parallax {

// Writes index.jsonl, dataset.json, README.md, croissant.json and LICENSE into `variant_dir`, each
// at once; nothing is written when the card can't be made. The numbers come from `index` and from
// what lies in the folder: frame.json of each frame and the recipes. A LICENSE that is there
// already stays, and the others name it. Errors: those of ReadFile and WriteFileAtomically;
// kDataLoss for a file that does not parse, naming it.
absl::Status WriteDatasetCard(const std::string& variant_dir, const v1::StudySpec& study,
                              const v1::VariantSpec& variant, const std::vector<IndexLine>& index);

}  // namespace parallax
