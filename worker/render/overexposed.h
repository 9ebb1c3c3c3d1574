// Finds where a picture is brighter than its display can show: lamps and surfaces close to them, up
// to a thousand times as bright as their surroundings. At such edges a pixel's few samples are off
// by all of the display's levels, and the denoiser blurs the edges and closes dark gaps. Single
// bright pixels (fireflies) are excluded.
#pragma once

#include <vector>

#include "common/image/image.h"
#include "worker/render/film.h"

namespace parallax {

// 1 where `radiance` times `exposure` is beyond the display in the pixel itself and in at least
// four of the nine pixels around and with it; else 0.
ImageU8 Overexposed(const ImageF3& radiance, float exposure);

// Pixels on both sides of the map's edges.
std::vector<PixelAt> EdgesOf(const ImageU8& overexposed);

// Removes from `radiance` the part beyond the display at overexposed pixels, before denoising, and
// returns it.
ImageF3 TakeExcess(const ImageU8& overexposed, float exposure, ImageF3* radiance);

}  // namespace parallax
