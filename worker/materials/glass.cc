// Families `glass` and `mirror`.
#include <array>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

using noise::Saturate;

// Panes and thin vessels: light passes straight through.
class ClearGlass final : public Material {
 public:
  explicit ClearGlass(Rng& rng) {
    color_ = Vec3f{Draw(rng, 0.86, 0.9), Draw(rng, 0.88, 0.9), Draw(rng, 0.87, 0.9)};
  }
  SurfaceSample8 Evaluate(const SurfacePoint8&) const override {
    return {.base_color = color_,
            .roughness = Splat(0.0f),
            .transmission = Splat(1),
            .ior = Splat(1.52f),
            .thin_walled = ~Mask8{}};
  }

 private:
  Vec3f color_;
};

// Massive: refracts. For closed bodies only.
class SolidGlass final : public Material {
 public:
  explicit SolidGlass(Rng& rng) {
    const Vec3f tint = HsvColor(rng.Uniform(0.3, 0.6), 0.25, 0.95);
    color_ = Mix(Vec3f::Constant(0.9f), tint, Draw(rng, 0, 0.5));
    ior_ = Draw(rng, 1.46, 1.6);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8&) const override {
    return {.base_color = Albedo(color_),
            .roughness = Splat(0.0f),
            .transmission = Splat(1),
            .ior = Splat(ior_)};
  }

 private:
  Vec3f color_;
  float ior_;
};

// Bottle green, amber, cobalt, smoke, rose; the tint runs a little thicker here and there.
class TintedGlass final : public Carved<TintedGlass> {
 public:
  explicit TintedGlass(Rng& rng) {
    static constexpr std::array<uint32_t, 9> kTints = {
        0x4f8a5b, 0xb9762f, 0x3a58a6, 0x6d6f72, 0xc98fa0, 0x7fb8b5, 0x8c6bb0, 0x2f4a35, 0xd8c27a};
    color_ = VaryColor(rng, SrgbColor(rng.Pick(kTints)), 0.15, 0.05);
    roughness_ = Draw(rng, 0.0, 0.06);
    wave_m_ = Draw(rng, 0.015, 0.05);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 thick = noise::Fbm3(point.texture_m, 2 * wave_m_, 3, point.footprint_m, seed_);
    return {.base_color = Albedo(color_ * (1.0f - 0.22f * thick)),
            .roughness = Splat(roughness_),
            .transmission = Splat(1),
            .ior = Splat(1.5f),
            .thin_walled = ~Mask8{}};
  }
  auto HeightOf(const auto& point) const {
    return 4e-5f * noise::Fbm3(point.texture_m, wave_m_, 2, point.footprint_m, seed_ + 3);
  }

 private:
  Vec3f color_;
  float roughness_, wave_m_;
};

// Sand-blasted or cast with a grain: lets light through but no picture.
class FrostedGlass final : public Carved<FrostedGlass> {
 public:
  explicit FrostedGlass(Rng& rng) {
    const Vec3f tint = HsvColor(rng.Uniform(), 0.3, 0.9);
    color_ = Mix(Vec3f::Constant(0.88f), tint, Draw(rng, 0, 0.4));
    roughness_ = Draw(rng, 0.3, 0.6);
    grain_m_ = rng.Bernoulli(0.5) ? Draw(rng, 0.004, 0.014) : 0.0015f;
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 n = noise::Fbm3(point.texture_m, 0.03f, 4, point.footprint_m, seed_, 0.6f);
    return {.base_color = Albedo(color_ * (0.96f + 0.1f * n)),
            .roughness = Saturate(roughness_ * (1.0f + 0.3f * n)),
            .transmission = Splat(1),
            .thin_walled = ~Mask8{}};
  }
  auto HeightOf(const auto& point) const {
    return 0.02f * grain_m_ * Grains(point.texture_m, point.footprint_m);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Grains(const Vec& p, Float8 w) const {
    const Float8 fade = noise::Fade(grain_m_, w);
    if (!Any(fade > 0)) return Splat(0);
    const auto d = noise::Cells3(p / grain_m_, seed_ + 7).f1;
    return fade * Saturate(1.0f - d * d);
  }

  Vec3f color_;
  float roughness_, grain_m_;
};

class Mirror final : public Material {
 public:
  explicit Mirror(Rng& rng) { color_ = Vec3f::Constant(Draw(rng, 0.82, 0.9)); }
  SurfaceSample8 Evaluate(const SurfacePoint8&) const override {
    return {.base_color = color_, .metallic = Splat(1), .roughness = Splat(0.0f)};
  }

 private:
  Vec3f color_;
};

// Silver that has gone in spots and clouds.
class AntiqueMirror final : public Material {
 public:
  explicit AntiqueMirror(Rng& rng) {
    level_ = Draw(rng, -0.62, -0.12);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Float8 cloud = noise::Fbm3(point.texture_m, 0.03f, 3, w, seed_ + 7);
    const Float8 gone = noise::Above(
        noise::Fbm3Filtered(point.texture_m, 0.16f, 6, w, seed_, 0.62f), 0.32f - level_, 0.28f);
    return {.base_color = Albedo(Mix(Vec3f(0.84f, 0.83f, 0.8f), Vec3f(0.10f, 0.09f, 0.08f), gone) *
                                 (1.0f - 0.06f * cloud)),
            .metallic = 1.0f - 0.6f * gone,
            .roughness = Saturate(0.03f + 0.45f * gone)};
  }

 private:
  float level_;
  uint32_t seed_;
};

}  // namespace

void AddGlassMaterials(MaterialList& list) {
  const MaterialTags glass = {.metal_or_glass = true};
  const MaterialTags clear = {.metal_or_glass = true, .smooth = true};
  list.push_back(Entry<ClearGlass>("ClearGlass", "glass", clear));
  list.push_back(Entry<FrostedGlass>("FrostedGlass", "glass", glass));
  list.push_back(Entry<SolidGlass>("SolidGlass", "glass", clear));
  list.push_back(Entry<TintedGlass>("TintedGlass", "glass", glass));
  list.push_back(Entry<AntiqueMirror>("AntiqueMirror", "mirror", glass));
  list.push_back(Entry<Mirror>("Mirror", "mirror", clear));
}

}  // namespace parallax
