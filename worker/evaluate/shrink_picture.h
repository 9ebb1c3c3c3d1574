#pragma once

#include "common/image/image.h"

namespace parallax {

// The picture reduced by a whole factor, by averaging; sides are rounded up, as Subsample's are.
ImageRgb8 ShrinkPicture(const ImageRgb8& picture, int factor);

}  // namespace parallax
