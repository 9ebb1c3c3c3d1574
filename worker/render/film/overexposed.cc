#include "worker/render/film/overexposed.h"

#include <algorithm>

namespace parallax {
namespace {

// After exposure. Display levels end at 2.4 (RollOff).
constexpr float kBeyondDisplay = 3.0f;
// Least number among nine: a pixel at a bright thing's corner has four, a firefly seldom over two.
constexpr int kFewestBright = 4;

// Counts the pixels with `is` among (x, y) and its up to eight neighbours.
template <typename Is>
int CountAround(int width, int height, int x, int y, const Is& is) {
  int count = 0;
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height - 1); ++v) {
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u) count += is(u, v);
  }
  return count;
}

}  // namespace

ImageU8 Overexposed(const ImageF3& radiance, float exposure) {
  const float limit = kBeyondDisplay / exposure;
  const int width = radiance.width(), height = radiance.height();
  const auto beyond = [&](int x, int y) {
    const float* pixel = radiance.At(x, y);
    return std::max({pixel[0], pixel[1], pixel[2]}) > limit;
  };
  ImageU8 overexposed(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (!beyond(x, y)) continue;
      overexposed(x, y) = CountAround(width, height, x, y, beyond) >= kFewestBright;
    }
  }
  return overexposed;
}

std::vector<PixelAt> EdgesOf(const ImageU8& overexposed) {
  const int width = overexposed.width(), height = overexposed.height();
  std::vector<PixelAt> edges;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const uint8_t here = overexposed(x, y);
      const auto differs = [&](int u, int v) { return overexposed(u, v) != here; };
      if (CountAround(width, height, x, y, differs) > 0) edges.push_back({x, y});
    }
  }
  return edges;
}

ImageF3 TakeExcess(const ImageU8& overexposed, float exposure, ImageF3* radiance) {
  const float limit = kBeyondDisplay / exposure;
  ImageF3 excess(radiance->width(), radiance->height());
  for (size_t i = 0; i < excess.values().size(); ++i) {
    float& value = radiance->values()[i];
    if (!overexposed.values()[i / 3] || value <= limit) continue;
    excess.values()[i] = value - limit;
    value = limit;
  }
  return excess;
}

}  // namespace parallax
