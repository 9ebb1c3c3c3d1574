#pragma once

#include "common/image/image.h"

namespace parallax {

// Returns the map with each pixel that is not finite filled with the smaller of the nearest finite
// disparities to its left and right in its row, because unmatched pixels mostly belong to the
// background behind an edge; at the border only one exists. A row without any value copies the row
// above, or the first one below that has values; an image without any becomes 0. Source: KITTI
// devkit, background interpolation.
ImageF FillHoles(ImageF disparity_px);

}  // namespace parallax
