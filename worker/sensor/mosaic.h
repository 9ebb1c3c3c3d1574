// A Bayer sensor: each pixel sees one colour, rows R G R G and G B G B in turn.
#pragma once

#include "common/image/image.h"

namespace parallax {

// Returns the colour that pixel (x, y) sees: 0 red, 1 green, 2 blue.
inline int MosaicChannel(int x, int y) { return (x & 1) + (y & 1); }

// Returns the raw picture that such a sensor records: one channel a pixel, same size as `picture`.
ImageF Mosaic(const ImageF3& picture);

// Reconstructs all three colours of each pixel from neighbours up to two pixels away, mirrored at
// the rim. A picture of constant colour is reproduced.
//   Source: Malvar, He, Cutler, "High-quality linear interpolation for demosaicing of
//   Bayer-patterned color images", ICASSP 2004.
ImageF3 Demosaic(const ImageF& mosaic);

}  // namespace parallax
