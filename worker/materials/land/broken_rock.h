// The relief of rock that broke along beds and joints.
#pragma once

#include "worker/materials/kernel/noise.h"

namespace parallax {

// Blocks broke off, as wide as `longest_m` and of `octaves` - 1 smaller sizes, each 0.43 of the one
// before.
struct BrokenRock {
  float longest_m = 1;
  uint32_t octaves = 3;
  uint32_t seed = 0;

  // Returns the height at `p` (metres, z across the beds; numbers or duals), metres: about 0.1 of
  // each size. Sizes too small for the footprint fade.
  template <typename Vec>
  RealOf<Vec> HeightAt(const Vec& p, Float8 footprint_m) const {
    RealOf<Vec> height = Splat(0);
    float wavelength_m = longest_m;
    for (uint32_t i = 0; i < octaves; ++i) {
      const Float8 fade = noise::Fade(wavelength_m, footprint_m);
      if (!Any(fade > 0)) break;
      // Blocks of beds are flatter than wide.
      const Vec q = VecOf(p.x, p.y, p.z * 2.1f) / wavelength_m;
      auto form =
          0.7f * noise::SmoothStep(-0.15f, Splat(0.12f), noise::Gradient3(q * 0.7f, seed + 51 + i));
      // Joints part the rock into blocks, each broken off at its own depth; few joints gape.
      if (i % 2 == 0) {
        const auto blocks = noise::Cells3(q, seed + 31 + i);
        const auto edge = blocks.f2 - blocks.f1;
        // Joints wander, but blocks meet at one height.
        const auto border = edge + 0.12f * noise::Gradient3(q * 3.3f, seed + 41 + i);
        const auto gaping =
            noise::SmoothStep(0.1f, Splat(0.4f), noise::Gradient3(q * 0.4f, seed + 91 + i));
        const Float8 depth = 1.6f * (noise::UnitByte(blocks.id, 0) - 0.5f);
        form = form +
               depth * noise::SmoothStep(0.0f, Splat(0.18f), border) *
                   noise::SmoothStep(0.0f, Splat(0.06f), edge) -
               0.3f * gaping * (1.0f - noise::SmoothStep(0.0f, Splat(0.06f), border));
      }
      height += (fade * (0.10f * wavelength_m)) * form;
      wavelength_m *= 0.43f;
    }
    return height;
  }
};

}  // namespace parallax
