// Checks a frame's pictures against the linear ones that it keeps.
#pragma once

#include <vector>

#include "worker/dataset/archive/dataset_reader.h"
#include "worker/dataset/verify/verify.h"

namespace parallax {

// Appends findings: linear pictures with values that are not numbers >= 0; pictures that differ
// from what the tone curve, or the sensor with the numbers in frame.json, makes of them; sensor
// pictures without linear ones. Frames without linear pictures are skipped.
void CheckLight(const DatasetFrame& frame, std::vector<Finding>& findings);

}  // namespace parallax
