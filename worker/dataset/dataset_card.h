// What a dataset is, for programs (dataset.json) and for people (README.md).
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/study.pb.h"
#include "worker/dataset/archive_index.h"

namespace parallax {

struct DatasetCard {
  std::string json;
  std::string markdown;
};

// From the index and from what lies in the variant's folder: frame.json of each frame and the
// recipes. Errors: reading as ReadFile; kDataLoss for a file that does not parse, naming it.
absl::StatusOr<DatasetCard> MakeDatasetCard(const std::string& variant_dir,
                                            const v1::StudySpec& study,
                                            const v1::VariantSpec& variant,
                                            const std::vector<IndexLine>& index);

}  // namespace parallax
