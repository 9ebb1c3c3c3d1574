// Checks occlusion against depth. Private to worker/dataset.
#pragma once

#include "worker/dataset/verify/checked_frame.h"

namespace parallax {

// Checks that occlusion is 0 or 255 and equals what re-projection of both views' depth gives (0.1 %
// of the pixels may differ), and that exact occlusion is 0 or 255, and 255 outside of the other
// picture. Appends to the frame's findings.
void CheckOcclusion(const CheckedFrame& frame);

}  // namespace parallax
