#include "worker/train/hidden_pixels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/image/fill_holes.h"

namespace parallax {

ImageF FillHiddenPixels(ImageF disparity_px) {
  const int width = disparity_px.width();
  std::vector<float> nearest(static_cast<size_t>(width));  // In the right view.
  std::vector<bool> hidden(static_cast<size_t>(width));
  for (int y = 0; y < disparity_px.height(); ++y) {
    float* const row = disparity_px.At(0, y);
    std::fill(nearest.begin(), nearest.end(), -1.0f);
    for (int x = 0; x < width; ++x) {
      const int at = static_cast<int>(std::floor(static_cast<float>(x) - row[x]));
      for (int to = std::max(0, at); to <= std::min(at + 1, width - 1); ++to) {
        nearest[to] = std::max(nearest[to], row[x]);
      }
    }
    for (int x = 0; x < width; ++x) {
      const float at = static_cast<float>(x) - row[x];
      hidden[x] = at < 0 || nearest[std::lround(at)] > row[x] + kHiddenBy;
    }
    if (std::find(hidden.begin(), hidden.end(), false) == hidden.end()) continue;
    for (int x = 0; x < width; ++x) {
      if (hidden[x]) row[x] = std::numeric_limits<float>::quiet_NaN();
    }
  }
  return FillHoles(std::move(disparity_px));
}

}  // namespace parallax
