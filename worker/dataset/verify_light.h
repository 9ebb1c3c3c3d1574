// The pictures of a frame against the linear ones that it keeps.
#pragma once

#include <vector>

#include "worker/dataset/dataset_reader.h"
#include "worker/dataset/verify.h"

namespace parallax {

// Appends what is wrong: linear pictures that are not numbers >= 0; pictures that are not what the
// tone curve, or the sensor with the numbers in frame.json, makes of them; a sensor's pictures
// without linear ones beside them. Frames that keep none are left alone.
void CheckLight(const DatasetFrame& frame, std::vector<Finding>& findings);

}  // namespace parallax
