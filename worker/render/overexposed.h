// Where a picture is brighter than its display can show: lamps and what is lit from close by, up to
// a thousand times as bright as their surroundings. There a pixel's few samples at an edge are off
// by all of the display's levels, and the denoiser blurs such edges and closes dark gaps in them.
// Single bright pixels (fireflies) are not meant.
#pragma once

#include <vector>

#include "common/image/image.h"
#include "worker/render/film.h"

namespace parallax {

// 1 where `radiance` times `exposure` is beyond the display in at least four of the nine pixels at
// and around it, itself among them.
ImageU8 Overexposed(const ImageF3& radiance, float exposure);

// Pixels of a map's edges, on both sides of them.
std::vector<PixelAt> EdgesOf(const ImageU8& overexposed);

// Takes out of `radiance` what is beyond the display at overexposed pixels, for the denoiser, and
// returns it.
ImageF3 TakeExcess(const ImageU8& overexposed, float exposure, ImageF3* radiance);

}  // namespace parallax
