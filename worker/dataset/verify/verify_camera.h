// Checks cameras against the study. Private to worker/dataset.
#pragma once

#include <vector>

#include "parallax/v1/config.pb.h"
#include "worker/dataset/archive/dataset_reader.h"
#include "worker/dataset/verify/verify.h"

namespace parallax {

// Checks that every frame has the camera that rigs.camera of its study's lock file gives: size, K
// and baseline, scaled to the size of the pictures, to 1e-6; drawn values must lie in their range.
// Checks nothing where the config gives no camera.
std::vector<Finding> CheckCameras(const DatasetVariant& variant, const v1::SceneConfig& config);

}  // namespace parallax
