// Family `metal`: tints are the normal reflectances of the clean metals; what differs is how the
// surface was worked.
#include <array>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

// Linear Rec. 709 reflectance at normal incidence.   Source: from the published n and k of the
// elements (refractiveindex.info), rounded; alloys by eye between their parts.
struct MetalTint {
  float r, g, b;
};
constexpr std::array<MetalTint, 9> kTints = {{{0.56f, 0.57f, 0.58f},    // Steel
                                              {0.88f, 0.61f, 0.50f},    // Copper
                                              {0.88f, 0.69f, 0.33f},    // Gold
                                              {0.83f, 0.69f, 0.42f},    // Brass
                                              {0.87f, 0.88f, 0.88f},    // Aluminium
                                              {0.70f, 0.53f, 0.36f},    // Bronze
                                              {0.55f, 0.56f, 0.56f},    // Chromium
                                              {0.66f, 0.61f, 0.53f},    // Nickel
                                              {0.24f, 0.24f, 0.25f}}};  // Blackened steel

Vec3f DrawTint(Rng& rng) {
  const MetalTint& tint = rng.Pick(kTints);
  return VaryColor(rng, {tint.r, tint.g, tint.b}, 0.06, 0.02);
}

// Lines along x, as from a belt; some deeper scratches.
class BrushedMetal final : public Carved<BrushedMetal> {
 public:
  explicit BrushedMetal(Rng& rng) {
    tint_ = DrawTint(rng);
    roughness_ = Draw(rng, 0.24, 0.42);
    depth_m_ = Draw(rng, 1.5e-6, 5e-6);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Float8 lines = Lines(point.texture_m, w);
    const Float8 broad = noise::Fbm3(point.texture_m, 0.12f, 2, w, seed_ + 5);
    return {.base_color = Albedo(tint_ * (1.0f + 0.13f * lines + 0.05f * broad)),
            .metallic = Splat(1),
            .roughness = Saturate(roughness_ * (1.0f + 0.25f * lines + 0.18f * broad))};
  }
  auto HeightOf(const auto& point) const {
    return depth_m_ * Lines(point.texture_m, point.footprint_m);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Lines(const Vec& p, Float8 w) const {
    RealOf<Vec> sum = Splat(0);
    const Float8 fine = Fade(0.7e-3f, w), middle = Fade(2.2e-3f, w), wide = Fade(9e-3f, w);
    if (Any(fine > 0))
      sum += 0.8f * fine * Gradient3(p.x * 14.0f, p.y * 1500.0f, p.z * 1500.0f, seed_);
    if (Any(middle > 0))
      sum += 0.7f * middle * Gradient3(p.x * 5.0f, p.y * 470.0f, p.z * 470.0f, seed_ + 1);
    if (Any(wide > 0))
      sum += 0.5f * wide * Gradient3(p.x * 1.5f, p.y * 110.0f, p.z * 110.0f, seed_ + 2);
    return sum;
  }

  Vec3f tint_;
  float roughness_, depth_m_;
};

// Bright, with the haze of hands and a few hairlines.
class PolishedMetal final : public Carved<PolishedMetal> {
 public:
  explicit PolishedMetal(Rng& rng) {
    tint_ = DrawTint(rng);
    roughness_ = Draw(rng, 0.05, 0.16);
    smudge_ = Draw(rng, 0.05, 0.22);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Float8 haze = SmoothStep(0.05f, 0.7f, noise::Fbm3(point.texture_m, 0.07f, 4, w, seed_));
    return {.base_color = Albedo(tint_ * (1.0f - 0.14f * haze)),
            .metallic = Splat(1),
            .roughness = Saturate(roughness_ + smudge_ * haze)};
  }
  // Sheet is never quite flat: long soft waves bend what is mirrored.
  auto HeightOf(const auto& point) const {
    return 6e-5f * noise::Fbm3(point.texture_m, 0.06f, 2, point.footprint_m, seed_ + 4, 0.25f);
  }

 private:
  Vec3f tint_;
  float roughness_, smudge_;
};

// Overlapping blows of a round hammer.
class HammeredMetal final : public Carved<HammeredMetal> {
 public:
  explicit HammeredMetal(Rng& rng) {
    tint_ = DrawTint(rng);
    roughness_ = Draw(rng, 0.15, 0.32);
    dent_m_ = Draw(rng, 0.007, 0.02);
    depth_ = Draw(rng, 0.035, 0.08);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Float8 fade = Fade(dent_m_, w);
    const Float8 bowl = Any(fade > 0) ? 0.4f + fade * (Bowl(point.texture_m) - 0.4f) : Splat(0.4f);
    const Float8 stain = noise::Fbm3(point.texture_m, 0.05f, 3, w, seed_ + 3);
    return {.base_color = Albedo(tint_ * (1.06f - 0.25f * bowl + 0.1f * stain)),
            .metallic = Splat(1),
            .roughness = Saturate(roughness_ * (0.9f + 0.5f * bowl + 0.3f * stain))};
  }
  template <typename Point>
  typename Point::Real HeightOf(const Point& point) const {
    const Float8 fade = Fade(dent_m_, point.footprint_m);
    if (!Any(fade > 0)) return Splat(0);
    return -depth_ * dent_m_ * fade * (1.0f - Bowl(point.texture_m));
  }

 private:
  // 0 in the middle of a dent, 1 on the ridges.
  template <typename Vec>
  RealOf<Vec> Bowl(const Vec& p) const {
    const auto d = noise::Cells3(p / dent_m_, seed_, 0.8f).f1;
    return Saturate(d * d * 1.3f);
  }

  Vec3f tint_;
  float roughness_, dent_m_, depth_;
};

// Iron with rust that spreads from patches, in tones from orange to brown.
class RustedMetal final : public Carved<RustedMetal> {
 public:
  explicit RustedMetal(Rng& rng) {
    iron_ = VaryColor(rng, Vec3f(0.34f, 0.34f, 0.35f), 0.15, 0.02);
    orange_ = VaryColor(rng, SrgbColor(0x8f5530), 0.1, 0.05);
    brown_ = VaryColor(rng, SrgbColor(0x46291c), 0.1, 0.05);
    level_ = Draw(rng, -0.25, 0.45);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 rust = Rust(p, w);
    const Float8 tone = noise::Fbm3(p, 0.02f, 4, w, seed_ + 7, 0.65f);
    const Vec3x8 oxide = Mix(brown_, orange_, SmoothStep(-0.5f, 0.6f, tone + 0.5f * rust - 0.3f));
    const Float8 stain = noise::Fbm3(p, 0.06f, 3, w, seed_ + 11);
    return {.base_color = Albedo(Mix(iron_ * (1.0f + 0.25f * stain), oxide, rust)),
            .metallic = 1.0f - rust,
            .roughness = noise::Lerp(0.42f + 0.12f * stain, 0.9f, rust),
            .specular = Splat(0.3f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto rust = Rust(point.texture_m, w);
    return rust * (1.5e-4f + 1.5e-4f * noise::Fbm3(point.texture_m, 0.006f, 3, w, seed_ + 7));
  }

 private:
  template <typename Vec>
  RealOf<Vec> Rust(const Vec& p, Float8 w) const {
    return noise::Above(noise::Fbm3Filtered(p, 0.13f, 6, w, seed_, 0.6f), -level_, 0.12f);
  }

  Vec3f iron_, orange_, brown_;
  float level_;
};

// Powder coat with orange peel; chipped to the metal in places.
class PaintedMetal final : public Carved<PaintedMetal> {
 public:
  explicit PaintedMetal(Rng& rng) {
    static constexpr std::array<uint32_t, 14> kCoats = {
        0xe4e3df, 0xd3d4d3, 0x2a2b2d, 0x46494d, 0x8a8f92, 0x1f3b57, 0x9b2a25,
        0x2f5a3c, 0xd9a521, 0xc8622d, 0x6f9aa8, 0xb7c4b1, 0x5c3a32, 0xd8cbb0};
    coat_ = VaryColor(rng, SrgbColor(rng.Pick(kCoats)), 0.1, 0.04);
    metal_ = Vec3f(0.5f, 0.5f, 0.51f);
    roughness_ = Draw(rng, 0.25, 0.55);
    chips_ = rng.Bernoulli(0.5) ? Draw(rng, 0.0, 0.16) : -1.0f;
    peel_m_ = Draw(rng, 0.0012, 0.004);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 dirt = noise::Fbm3(p, 0.15f, 4, w, seed_ + 3);
    const Float8 chip = Chip(p, w);
    return {.base_color = Albedo(Mix(coat_ * (1.0f + 0.11f * dirt), metal_, chip)),
            .metallic = chip,
            .roughness = Saturate(roughness_ * (1.0f + 0.15f * dirt))};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    return 1.6e-5f * noise::Fbm3(point.texture_m, peel_m_, 2, w, seed_ + 6) -
           1.2e-4f * Chip(point.texture_m, w);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Chip(const Vec& p, Float8 w) const {
    if (chips_ < 0) return Splat(0);
    return noise::Above(noise::Fbm3Filtered(p, 0.06f, 5, w, seed_, 0.6f), 0.8f - chips_, 0.02f);
  }

  Vec3f coat_, metal_;
  float roughness_, chips_, peel_m_;
};

// Zinc crystals, each turned its own way: bright and dull flakes.
class GalvanizedMetal final : public Carved<GalvanizedMetal> {
 public:
  explicit GalvanizedMetal(Rng& rng) {
    zinc_ = VaryColor(rng, Vec3f(0.52f, 0.54f, 0.56f), 0.08, 0.02);
    flake_m_ = Draw(rng, 0.006, 0.022);
    contrast_ = Draw(rng, 0.25, 0.55);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    Float8 tone = Splat(0), rough = Splat(0);
    const Float8 fade = Fade(flake_m_, w);
    if (Any(fade > 0)) {
      const Float8 wobble = 0.25f * Gradient3(point.texture_m / (0.3f * flake_m_), seed_ + 1);
      const noise::Cell8 cell =
          noise::Cells3(point.texture_m / flake_m_ + Vec3x8::All(wobble), seed_);
      tone = fade * (UnitByte(cell.id, 0) - 0.5f);
      rough = fade * (UnitByte(cell.id, 1) - 0.5f);
      // Feathers within a flake, along its own direction.
      const Float8 turn = UnitByte(cell.id, 2);
      const Float8 feather = noise::CosTurn(
          turn + 9.0f * (cell.offset.x * (turn - 0.5f) + cell.offset.y * UnitByte(cell.id, 3)));
      tone += 0.18f * feather * Fade(0.12f * flake_m_, w);
    }
    const Float8 broad = noise::Fbm3(point.texture_m, 0.2f, 2, w, seed_ + 3);
    return {.base_color = Albedo(zinc_ * (1.0f + contrast_ * tone + 0.08f * broad)),
            .metallic = Splat(1),
            .roughness = Saturate(0.45f + 0.25f * rough + 0.05f * broad)};
  }
  auto HeightOf(const auto& point) const {
    return 8e-6f * noise::Fbm3(point.texture_m, 0.004f, 2, point.footprint_m, seed_ + 4);
  }

 private:
  Vec3f zinc_;
  float flake_m_, contrast_;
};

// Sand-cast, dark and rough: stoves, pans, radiators.
class CastIron final : public Carved<CastIron> {
 public:
  explicit CastIron(Rng& rng) {
    iron_ = VaryColor(rng, Vec3f(0.09f, 0.09f, 0.095f), 0.2, 0.02);
    grain_m_ = Draw(rng, 0.0012, 0.003);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Float8 n = noise::Fbm3(point.texture_m, 0.05f, 5, w, seed_, 0.65f);
    return {.base_color = Albedo(iron_ * (1.0f + 0.35f * n)),
            .metallic = Splat(0.8f),
            .roughness = Saturate(0.55f + 0.12f * n)};
  }
  auto HeightOf(const auto& point) const {
    return 7e-5f * noise::Fbm3(point.texture_m, grain_m_, 2, point.footprint_m, seed_ + 8);
  }

 private:
  Vec3f iron_;
  float grain_m_;
};

}  // namespace

void AddMetalMaterials(MaterialList& list) {
  const MaterialTags metal = {.metal_or_glass = true};
  list.push_back(Entry<BrushedMetal>("BrushedMetal", "metal", metal));
  list.push_back(Entry<CastIron>("CastIron", "metal", metal));
  list.push_back(Entry<GalvanizedMetal>("GalvanizedMetal", "metal", metal));
  list.push_back(Entry<HammeredMetal>("HammeredMetal", "metal", metal));
  list.push_back(Entry<PaintedMetal>("PaintedMetal", "metal", {}));
  list.push_back(Entry<PolishedMetal>("PolishedMetal", "metal", metal));
  list.push_back(
      Entry<RustedMetal>("RustedMetal", "metal", {.metal_or_glass = true, .weathered = true}));
}

}  // namespace parallax
