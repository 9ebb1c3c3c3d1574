// Parts that printed and painted pictures share: their ground, lettering, small print.
#pragma once

#include <string>

#include "worker/materials/art/art.h"
#include "worker/materials/kernel/material_families.h"

namespace parallax {

// The ground of a picture.
enum class PictureGround { kCanvas, kPaper, kCoated };

// Common to all pictures: the ground they are on, and their fading to one colour from far away.
class Printed : public PointMaterial {
 public:
  SurfaceSample EvaluatePoint(const SurfacePoint& point) const override {
    const float w = point.footprint_uv > 0 ? point.footprint_uv : point.footprint_m * 2.0f;
    const float u = noise::Saturate(point.uv.x()), v = noise::Saturate(point.uv.y());
    const float shown = noise::Fade(0.9f, w);
    Vec3f color = mean_;
    if (shown > 0) color = Mix(mean_, Ink(u, v, w), shown);
    const float grain = Grain(point);
    const float age = noise::Fbm3(point.texture_m, 0.12f, 3, point.footprint_m, seed_);
    return {.base_color = Albedo(color * (1.0f + 0.07f * grain + 0.03f * age)),
            .roughness = noise::Saturate(roughness_ * (1.0f + 0.12f * grain + 0.1f * age)),
            .specular = ground_ == PictureGround::kCanvas ? 0.4f : 0.5f};
  }
  float HeightOfPoint(const SurfacePoint& point) const override {
    return (ground_ == PictureGround::kCanvas ? 7e-5f : 8e-6f) * Grain(point);
  }

 protected:
  Printed(Rng& rng, PictureGround ground) : ground_(ground) {
    roughness_ = ground == PictureGround::kCanvas  ? Draw(rng, 0.45, 0.75)
                 : ground == PictureGround::kPaper ? Draw(rng, 0.6, 0.85)
                                                   : Draw(rng, 0.15, 0.45);
    seed_ = DrawSeed(rng);
  }
  virtual Vec3f Ink(float u, float v, float w) const = 0;
  // The last thing a constructor does.
  void MeasureMean() {
    constexpr int kSide = 20;
    mean_.setZero();
    for (int i = 0; i < kSide * kSide; ++i) {
      mean_ += Ink((Float(i % kSide) + 0.5f) / kSide, (Float(i / kSide) + 0.5f) / kSide, 0.02f);
    }
    mean_ /= kSide * kSide;
  }
  uint32_t seed() const { return seed_; }

 private:
  float Grain(const SurfacePoint& point) const {
    const PlanePoint plane = OnPlane(point);
    const float w = point.footprint_m;
    if (ground_ != PictureGround::kCanvas) {
      return noise::Fade(2e-3f, w) *
             noise::Gradient2(plane.u * 500.0f, plane.v * 500.0f, seed_ + 1);
    }
    // Canvas under paint: threads, and strokes of a brush that turn slowly.
    const float fade = noise::Fade(1.6e-3f, w);
    const float thread =
        fade > 0
            ? fade * 0.5f * (noise::CosTurn(plane.u * 700.0f) + noise::CosTurn(plane.v * 700.0f))
            : 0.0f;
    const float stroke = noise::Fade(3e-3f, w) * noise::Gradient2(plane.u * 60.0f + 20.0f * plane.v,
                                                                  plane.v * 330.0f, seed_ + 2);
    return 0.4f * thread + stroke;
  }

  PictureGround ground_;
  float roughness_;
  uint32_t seed_;
  Vec3f mean_ = Vec3f::Zero();
};

// A word of nonsense in capitals.
std::string DrawWord(Rng& rng, int syllables);

// One line of lettering in a box of the picture.
struct Lettering {
  std::string text;
  float u = 0, v = 0, width = 1,
        height = 0.1f;  // Lower left corner and size of the box that the text fills.
  float stroke = 0.5f;  // Half the pen's width in cell units.
  Vec3f color = Vec3f::Constant(0.05f);

  // The colour at (u, v) with the line over `under`; `w`: footprint.
  Vec3f Over(const Vec3f& under, float at_u, float at_v, float w) const;
};

// A block of small print: lines of words of random lengths that nobody reads.
struct SmallPrint {
  float u0 = 0, v0 = 0, u1 = 1, v1 = 1;
  float line = 0.03f;  // From line to line.
  Vec3f color = Vec3f::Constant(0.08f);
  uint32_t seed = 0;

  // The colour at (u, v) with the block over `under`; `w`: footprint.
  Vec3f Over(const Vec3f& under, float u, float v, float w) const;
};

}  // namespace parallax
