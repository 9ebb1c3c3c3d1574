// Evaluates the GroundMasks of a recipe on the ground. Pure; thread-safe.
#pragma once

#include "parallax/v1/scene.pb.h"
#include "worker/terrain/terrain.h"

namespace parallax {

// A GroundMask without its shade, which depends on more than the ground.
class MaskOnGround {
 public:
  explicit MaskOnGround(const v1::GroundMask& mask);

  // Value of the mask in [0, 1] at `p`, world.
  float At(const Terrain& terrain, const Vec2f& p) const;
  // The factor in [0, 1] for shade.
  float OfShade(float shade) const { return shade_.At(shade); }
  bool needs_shade() const { return !shade_.everywhere; }

  // Straight rows, one through the origin; rows_m is 0 without any.
  float rows_m() const { return rows_m_; }
  float row_width_m() const { return 2 * half_row_m_; }
  const Vec2f& across() const { return across_; }  // Unit, from one row to the next.

 private:
  // v1::SoftRange.
  struct Range {
    float low = 0, high = 0, soft = 0;
    bool everywhere = true;
    explicit Range(const v1::SoftRange& range);
    float At(float x) const;
  };
  float NoiseAt(const Vec2f& p) const;
  bool IsInRow(const Vec2f& p) const;

  Range slope_, height_, above_water_, wetness_, deposit_, shade_, snow_;
  float noise_m_, threshold_, noise_soft_;
  uint32_t noise_seed_;
  float rows_m_, half_row_m_;
  Vec2f across_;  // Unit, from one row to the next.
};

}  // namespace parallax
