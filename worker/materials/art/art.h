// Flat pictures over the unit square, u to the right and v up, for paintings, posters, covers and
// screens.
#pragma once

#include <array>
#include <memory>

#include "worker/materials/kernel/surface.h"

namespace parallax {

// A picture as a function. Constant; thread-safe.
class Art {
 public:
  virtual ~Art() = default;
  // Returns the linear colour at a point of [0, 1]^2, for a footprint of width `w` (in the same
  // units). Not yet limited to albedos.
  virtual Vec3f At(float u, float v, float w) const = 0;

 protected:
  uint32_t seed_ = 0;  // Seed of its noise, which the style draws.
};

// The families of pictures.
enum class ArtStyle {
  kLandscape,  // Sky, sun, ridges behind ridges, sometimes a sea.
  kCity,       // Towers with lit windows.
  kFields,     // Two to four soft fields of colour.
  kBlocks,     // Rectangles between black bars.
  kModules,    // A grid of quarter circles, stripes, triangles.
  kCircles,    // Discs, rings and bars at random.
  kFluid,      // Poured paint.
  kCells,      // Leaded glass.
  kWaves,      // Displaced stripes.
  kBotanical,  // Stems with leaves and flowers.
  kFigure,     // A head and shoulders.
  kCount
};

// Draws a picture of the style, or of any.
std::unique_ptr<const Art> DrawArt(Rng& rng, ArtStyle style);
std::unique_ptr<const Art> DrawAnyArt(Rng& rng);

// Draws five colours that suit each other, the darkest first.
std::array<Vec3f, 5> DrawPalette(Rng& rng);

}  // namespace parallax
