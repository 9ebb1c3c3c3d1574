// Parts that the families of art share. Private to art*.cc.
#pragma once

#include <array>
#include <cmath>
#include <memory>

#include "worker/materials/art/art.h"
#include "worker/materials/kernel/noise.h"
#include "worker/materials/kernel/surface.h"

namespace parallax::art {

using Palette = std::array<Vec3f, 5>;

inline float Length(float x, float y) { return std::sqrt(x * x + y * y); }
// Returns how much of a footprint of width `w` lies inside a shape, by the signed distance of its
// middle from the shape's edge (negative inside): 1 inside, 0 outside.
inline float Inside(float distance, float w) { return 1.0f - Edge(distance, 0.002f, 1.2f * w); }
inline const Vec3f& PickFrom(const Palette& palette, uint32_t hash) {
  return palette[hash % palette.size()];
}

// Return a picture of the style, or null if the style belongs to the other family.
std::unique_ptr<const Art> DrawScene(Rng& rng, ArtStyle style);     // Landscape, city, figure...
std::unique_ptr<const Art> DrawAbstract(Rng& rng, ArtStyle style);  // Fields, blocks, waves...

}  // namespace parallax::art
