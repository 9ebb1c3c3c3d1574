// Pixels of the left view that the right eye does not see: a network guesses their disparities,
// mostly too large, because it has seen the nearer surface beside them match.
#pragma once

#include "common/image/image.h"

namespace parallax {

// Returns the map with its hidden pixels filled from the background beside them, by FillHoles. The
// map itself says which they are: those that another pixel of the row, at least kHiddenBy px
// nearer, covers in the right view, and those that lie to the left of it. A row without any other
// pixel stays as it is. `disparity_px` is finite and >= 0.
ImageF FillHiddenPixels(ImageF disparity_px);
inline constexpr float kHiddenBy = 1;

}  // namespace parallax
