// Checks the layers of a frame. Private to worker/dataset.
#pragma once

#include "worker/dataset/verify/checked_frame.h"

namespace parallax {

// Checks a frame that has layers, of both eyes: the first layer is that of the other maps; each
// lies behind the one before it, and that one is see-through; disparity is fx * baseline / depth;
// indices are in the tables; files are there exactly where a pixel has such a layer.
void CheckLayers(const CheckedFrame& frame);

}  // namespace parallax
