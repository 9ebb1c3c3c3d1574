#pragma once

#include "common/image/image.h"

namespace parallax {

// Gives each pixel that is not finite the smaller of the nearest finite disparities to its left and
// right in its row, because what was not matched is mostly background behind an edge; at the border
// the only one there is. A row without any takes the row above, or the first one below that has
// some; an image without any becomes 0. Source: KITTI devkit, background interpolation.
ImageF FillHoles(ImageF disparity_px);

}  // namespace parallax
