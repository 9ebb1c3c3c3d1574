#pragma once

#include "common/image/image.h"

namespace parallax {

// Shrinks the picture by a whole factor, averaging; sides are rounded up, as in Subsample.
ImageRgb8 ShrinkPicture(const ImageRgb8& picture, int factor);

}  // namespace parallax
