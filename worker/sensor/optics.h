// The effects of a lens on a linear picture before it is measured. Pictures keep their size; the
// rim is mirrored. Thread-safe.
#pragma once

#include "common/image/image.h"

namespace parallax {

// Blurs by a Gaussian of this standard deviation, in pixels; 0 does nothing.
void SpreadPoints(double sigma_px, ImageF3& picture);

// Returns the diameter in pixels of the circle over which a thin lens that is focused at `focus_m`
// spreads a point at depth `depth_m`; a depth of 0 stands for infinity, where it is `defocus_px`.
//   Source: Hecht, "Optics", thin lens equation: c(z) = c(infinity) * |1 - focus / z|.
double CircleOfConfusion(double defocus_px, double focus_m, double depth_m);

// Replaces each pixel by the mean over its own circle of confusion, at most 64 pixels wide.
// `depth_m` has the picture's size. A sharp thing keeps its edge, and what is blurred does not
// reach over it.
void Defocus(double defocus_px, double focus_m, const ImageF& depth_m, ImageF3& picture);

// Darkens towards the corners, which lose the share `vignetting`, in [0, 1): by 1 / (1 + k r^2)^2
// with r the distance from the middle: the cosine-fourth law of natural vignetting.
void Vignette(double vignetting, ImageF3& picture);

}  // namespace parallax
