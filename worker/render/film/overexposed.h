// Finds where a picture is brighter than its display can show: lamps and surfaces close to them, up
// to a thousand times as bright as their surroundings. At their edges a pixel's few samples may be
// wrong by the display's whole range, and the denoiser blurs the edges and closes dark gaps. Single
// bright pixels (fireflies) do not count.
#pragma once

#include <vector>

#include "common/image/image.h"
#include "worker/render/film/film.h"

namespace parallax {

// Returns a map that is 1 where `radiance` times `exposure` exceeds the display's range, in the
// pixel itself and in at least four of the 3 x 3 pixels about it; else 0.
ImageU8 Overexposed(const ImageF3& radiance, float exposure);

// Returns the pixels on both sides of the map's edges.
std::vector<PixelAt> EdgesOf(const ImageU8& overexposed);

// Removes from `radiance` the part beyond the display at overexposed pixels, before denoising, and
// returns it.
ImageF3 TakeExcess(const ImageU8& overexposed, float exposure, ImageF3* radiance);

}  // namespace parallax
