// Checks the files of one frame against the index. Private to worker/dataset.
#pragma once

#include <cstdint>
#include <vector>

#include "worker/dataset/archive/dataset_reader.h"
#include "worker/dataset/verify/verify.h"

namespace parallax {

// Checks that the index's files exist, with the right SHA-256 if `hashes`, and that no others do.
// Appends to `findings` and adds the files' sizes to `bytes`.
void CheckFiles(const DatasetFrame& frame, bool hashes, std::vector<Finding>& findings,
                int64_t& bytes);

}  // namespace parallax
