// The checks of infrared pictures. Private to worker/dataset.
#pragma once

#include <vector>

#include "worker/dataset/archive/dataset_reader.h"
#include "worker/dataset/verify/verify.h"

namespace parallax {

// Checks a frame whose frame.json, `json`, has `infrared`: both pictures are there, grey and of the
// pair's size, and what they show of the projector agrees with the depth maps. Where depth says
// that a dot falls, and that nothing stands between it and the projector, the picture is brighter
// than around it, on average over all dots, if the projector is strong enough for that; in the
// projector's shadow it is not.
std::vector<Finding> CheckInfrared(const DatasetFrame& frame, const nlohmann::ordered_json& json);

}  // namespace parallax
