// Checks the verdicts of filters in the index against the maps. Private to worker/dataset.
#pragma once

#include "worker/dataset/verify/checked_frame.h"

namespace parallax {

// Checks that each verdict follows from its value and threshold, that the values are those of the
// frame's pictures and depth, and that the frame passed if every filter did. Appends to the
// frame's findings. Throws nlohmann's exceptions if a verdict's number has another type.
void CheckFilters(const CheckedFrame& frame);

}  // namespace parallax
