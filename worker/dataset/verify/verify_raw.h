// Checks the pair before rectification. Private to worker/dataset.
#pragma once

#include <vector>

#include "worker/dataset/archive/dataset_reader.h"
#include "worker/dataset/verify/verify.h"

namespace parallax {

// Checks a frame whose frame.json, `json`, has raw cameras: pictures, flow and occlusion have the
// cameras' sizes; flow is finite, its third channel 0 or 1, occlusion 0 or 255; rectification
// brings both ends of a correspondence within both pictures into one row, to 0.01 px (of the raw
// picture, where that is less), with disparity >= 0; and that disparity equals the rectified maps'
// (to 1 px or 2 %, for all but 5 % of the visible pixels).
std::vector<Finding> CheckRawPair(const DatasetFrame& frame, const nlohmann::ordered_json& json);

}  // namespace parallax
