// Linear Rec. 709 colours.
#pragma once

#include "common/math/types.h"

namespace parallax {

// Returns the relative luminance.   Source: ITU-R BT.709.
inline float Luminance(const Vec3f& rgb) {
  return 0.2126f * rgb.x() + 0.7152f * rgb.y() + 0.0722f * rgb.z();
}

}  // namespace parallax
