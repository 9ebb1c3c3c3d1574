#include "common/image/fill_holes.h"

#include <algorithm>
#include <cmath>

namespace parallax {
namespace {

// False when the row has nothing to fill from.
bool FillRow(float* row, int width) {
  int last = -1;  // The last finite pixel.
  for (int x = 0; x < width; ++x) {
    if (!std::isfinite(row[x])) continue;
    const float value = last < 0 ? row[x] : std::min(row[last], row[x]);
    std::fill(row + last + 1, row + x, value);
    last = x;
  }
  if (last < 0) return false;
  std::fill(row + last + 1, row + width, row[last]);
  return true;
}

}  // namespace

ImageF FillHoles(ImageF disparity_px) {
  const int width = disparity_px.width(), height = disparity_px.height();
  int source = -1;  // The last row that has values.
  for (int y = 0; y < height; ++y) {
    if (FillRow(disparity_px.At(0, y), width)) {
      // Rows above the first good one take it.
      for (int above = source < 0 ? 0 : y; above < y; ++above) {
        std::copy_n(disparity_px.At(0, y), width, disparity_px.At(0, above));
      }
      source = y;
    } else if (source >= 0) {
      std::copy_n(disparity_px.At(0, source), width, disparity_px.At(0, y));
    }
  }
  if (source < 0) std::fill(disparity_px.values().begin(), disparity_px.values().end(), 0.0f);
  return disparity_px;
}

}  // namespace parallax
