// Describes a dataset for programs (dataset.json, croissant.json) and for people (README.md,
// LICENSE).
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/study.pb.h"
#include "worker/dataset/archive/archive_index.h"

namespace parallax {

// Writes index.jsonl, dataset.json, README.md, croissant.json and LICENSE into `variant_dir`, each
// atomically; writes nothing when the card can't be made. The numbers come from `index` and from
// the folder: each frame's frame.json and the recipes. An existing LICENSE stays, and the others
// name it. Errors: those of ReadFile and WriteFileAtomically; kDataLoss for a file that does not
// parse, naming it.
absl::Status WriteDatasetCard(const std::string& variant_dir, const v1::StudySpec& study,
                              const v1::VariantSpec& variant, const std::vector<IndexLine>& index);

}  // namespace parallax
