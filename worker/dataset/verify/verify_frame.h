// Checks one frame. Private to worker/dataset.
#pragma once

#include <vector>

#include "worker/dataset/archive/dataset_reader.h"
#include "worker/dataset/verify/verify.h"

namespace parallax {

// Checks the geometry between a frame's files. Maps that were not written are not missed; maps that
// can't be read are findings.
void CheckGeometry(const DatasetFrame& frame, std::vector<Finding>& findings);

}  // namespace parallax
