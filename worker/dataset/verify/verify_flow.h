// The check of a frame's flow maps. Private to worker/dataset.
#pragma once

#include <vector>

#include "worker/dataset/archive/dataset_reader.h"
#include "worker/dataset/verify/verify.h"

namespace parallax {

// Checks whether flow and disparity change are what depth, objects and the recipe's cameras and
// motion give, worked out anew; whether occlusion agrees with the depth of the neighbouring frames,
// where they are in the dataset; whether frame.json names the neighbours and places of moving
// objects as the recipe does. Frames without flow maps and sequence have no findings.
void CheckFlow(const DatasetFrame& frame, std::vector<Finding>& findings);

}  // namespace parallax
