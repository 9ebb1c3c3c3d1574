// Gradient noise for wrinkles, dents and crookedness. Constant after construction; thread-safe.
#pragma once

#include <cstdint>

#include "common/base/rng.h"
#include "common/math/types.h"

namespace parallax::kernel {

// A scalar field with features one unit wide.
class Noise {
 public:
  explicit Noise(uint64_t seed) : seed_(seed) {}
  explicit Noise(Rng& rng) : seed_(rng.Seed()) {}

  // About [-1, 1], mean 0, features one unit wide.   Source: Perlin, "Improving noise", SIGGRAPH
  // 2002.
  float At(const Vec3f& p) const;
  // Three independent fields.
  Vec3f Vector(const Vec3f& p) const;
  // Sum of `octaves`, each with half the wavelength and amplitude of the one before.
  float Fractal(const Vec3f& p, int octaves) const;
  // Folds with sharp ridges and soft valleys, in [0, 1].
  float Ridges(const Vec3f& p) const;

 private:
  uint64_t seed_;
};

}  // namespace parallax::kernel
