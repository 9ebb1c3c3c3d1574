// Parts that the families of art share. Private to art*.cc.
#pragma once

#include <array>
#include <cmath>
#include <memory>

#include "worker/materials/art.h"
#include "worker/materials/noise.h"
#include "worker/materials/surface.h"

namespace parallax::art {

using Palette = std::array<Vec3f, 5>;

inline float Length(float x, float y) { return std::sqrt(x * x + y * y); }
// 1 inside (distance < 0), 0 outside, filtered over a footprint of width `w`.
inline float Inside(float distance, float w) { return 1.0f - Edge(distance, 0.002f, 1.2f * w); }
inline const Vec3f& PickFrom(const Palette& palette, uint32_t hash) {
  return palette[hash % palette.size()];
}

// A picture of the style, or null when the style is of the other family.
std::unique_ptr<const Art> DrawScene(Rng& rng, ArtStyle style);     // Landscape, city, figure...
std::unique_ptr<const Art> DrawAbstract(Rng& rng, ArtStyle style);  // Fields, blocks, waves...

}  // namespace parallax::art
