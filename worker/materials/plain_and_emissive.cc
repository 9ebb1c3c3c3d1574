// Families `plain` (the study's "no materials" mode) and `emissive`.
#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

class PlainGrey final : public Material {
 public:
  explicit PlainGrey(Rng&) {}
  SurfaceSample8 Evaluate(const SurfacePoint8&) const override {
    return {.base_color = Vec3x8::All(Splat(0.5f)), .roughness = Splat(0.6f)};
  }
};

// Linear Rec. 709 of a black body, green 1; 2400..6500 K.   Source: fit by eye to Planck's law
// through CIE 1931.
Vec3f WarmWhite(double kelvin) {
  const double t = (kelvin - 2400) / (6500 - 2400);
  return {Float(1.0 + 0.95 * (1 - t) * (1 - t)), 1.0f, Float(0.22 + 0.80 * std::pow(t, 0.8))};
}

// A bulb or a lit shade: brightest in its middle, so that it does not look cut out of paper.
class LampBulb final : public Material {
 public:
  explicit LampBulb(Rng& rng) {
    color_ = WarmWhite(rng.Uniform(2600, 5200));
    radiance_ = Draw(rng, 12, 40);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 n = noise::Fbm3(point.texture_m, 0.04f, 2, point.footprint_m, seed_);
    return {.base_color = Vec3x8::All(0.78f * (1.0f + 0.09f * n)),
            .roughness = Splat(0.5f),
            .emission = color_ * (radiance_ * (1.0f + 0.08f * n))};
  }

 private:
  Vec3f color_;
  float radiance_;
  uint32_t seed_;
};

}  // namespace

void AddPlainMaterials(MaterialList& list) {
  list.push_back(Entry<PlainGrey>("PlainGrey", "plain",
                                  {.diffuse = true, .any_object = false, .smooth = true}));
  list.push_back(Entry<LampBulb>("LampBulb", "emissive", {.any_object = false}));
}

}  // namespace parallax
