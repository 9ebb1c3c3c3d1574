#include "worker/evaluate/visibility.h"

#include <cmath>

namespace parallax {

ImageU8 VisibilityMask(const ImageF& left_px, const ImageF& right_px, float tolerance_px) {
  ImageU8 mask(left_px.width(), left_px.height(), kMaskUnknown);
  for (int y = 0; y < mask.height(); ++y) {
    for (int x = 0; x < mask.width(); ++x) {
      const float d = left_px(x, y);
      if (!(d > 0)) continue;
      const auto x1 = static_cast<int>(std::round(static_cast<float>(x) - d));
      const bool inside = x1 >= 0 && x1 < mask.width();
      const float d1 = inside ? right_px(x1, y) : 0;
      mask(x, y) = d1 > 0 && std::abs(d - d1) <= tolerance_px ? kMaskVisible : kMaskOccluded;
    }
  }
  return mask;
}

ImageU8 VisibleOf(const ImageU8& mask) {
  ImageU8 visible(mask.width(), mask.height());
  for (size_t i = 0; i < mask.pixels(); ++i) visible.values()[i] = mask.values()[i] == kMaskVisible;
  return visible;
}

}  // namespace parallax
