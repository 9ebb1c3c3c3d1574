// Families `sand` and `rock`: what lies on the ground and what stands out of it.
#include <array>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"
#include "worker/materials/land/forest_parts.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

// Grains of quartz, each its own tint, in ripples that the wind left; darker where it is damp, here
// and there a bit of shell.
class Sand final : public Carved<Sand> {
 public:
  explicit Sand(Rng& rng) {
    static constexpr std::array<uint32_t, 7> kSands = {0xd9c7a3, 0xc7ab7d, 0xe6dcc8, 0xb58a5f,
                                                       0x8f8578, 0x55504b, 0xc2744a};
    sand_ = VaryColor(rng, SrgbColor(rng.Pick(kSands)), 0.1, 0.04);
    damp_ = sand_ * Draw(rng, 0.5, 0.7);
    shell_ = SrgbColor(0xece4d6);
    grain_m_ = Draw(rng, 0.0006, 0.0013);
    spread_ = Draw(rng, 0.5, 1.1);
    ripple_m_ = Draw(rng, 0.03, 0.085);
    depth_m_ = ripple_m_ * Draw(rng, 0.02, 0.09);
    wet_ = rng.Bernoulli(0.5) ? Draw(rng, 0.3, 0.9) : 0.0f;
    shells_ = rng.Bernoulli(0.5) ? Draw(rng, 0.01, 0.05) : 0.0f;
    const float turn = Draw(rng, 0, 6.2831853);
    across_ = Vec3f(std::cos(turn), std::sin(turn), 0.4f);
    seed_ = DrawSeed(rng);
  }

  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 fade = Fade(2.0f * grain_m_, w);
    Float8 tone = Splat(0), dark = Splat(0.033f), lit = Splat(kMeanTop);
    if (Any(fade > 0)) {
      const noise::Cell8 cell = noise::Cells3(p / grain_m_, seed_);
      tone = fade * spread_ * (UnitByte(cell.id, 0) - 0.5f);
      dark = fade * (UnitByte(cell.id, 1) > 0.94f ? Splat(0.55f) : Splat(0)) + (1 - fade) * 0.033f;
      lit += fade * (Grain(cell) - kMeanTop);
    }
    const Float8 damp =
        wet_ * noise::Above(noise::Fbm3Filtered(p, 0.16f, 5, w, seed_ + 3, 0.6f), 0.12f, 0.12f);
    const Float8 broad = Fbm3(p, 0.07f, 4, w, seed_ + 4, 0.6f);
    // Coarse, light grains gather on the crests.
    const Float8 crest = Ripples(p, w);
    Vec3x8 color = Mix(sand_, damp_, damp);
    color *= (1.0f + tone) * (0.62f + 0.6f * lit) * (1.0f + 0.1f * broad + 0.14f * crest) *
             (1.0f - dark);
    return {.base_color = Albedo(Mix(color, shell_, Shells(p, w))),
            .roughness = Saturate(0.95f - 0.35f * damp),
            .specular = Splat(0.3f)};
  }

  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto& p = point.texture_m;
    return 0.2f * grain_m_ * Grains(p, w) + depth_m_ * Ripples(p, w) +
           4e-4f * Fbm3(p, 0.025f, 3, w, seed_ + 6) + 6e-4f * Shells(p, w);
  }

 private:
  static constexpr float kMeanTop = 0.55f;

  template <typename Vec>
  RealOf<Vec> Grains(const Vec& p, Float8 w) const {
    const Float8 fade = Fade(2.0f * grain_m_, w);
    if (!Any(fade > 0)) return Splat(0);
    return fade * Grain(noise::Cells3(p / grain_m_, seed_));
  }
  template <typename Vec>
  static RealOf<Vec> Grain(const noise::CellOf8<Vec>& cell) {
    return Saturate(1.0f - 0.9f * cell.f1 * cell.f1) * SmoothStep(0.0f, 0.3f, cell.f2 - cell.f1);
  }
  // Crests that wander, fork and die out; about [-1, 1].
  template <typename Vec>
  RealOf<Vec> Ripples(const Vec& p, Float8 w) const {
    const Float8 fade = Fade(ripple_m_, w);
    if (!Any(fade > 0)) return Splat(0);
    const auto wander = 0.9f * Gradient3(p / (2.6f * ripple_m_), seed_ + 8) +
                        0.35f * Gradient3(p / (0.9f * ripple_m_), seed_ + 9);
    const auto x = Along(across_, p) / ripple_m_ + wander;
    const auto strength = SmoothStep(-0.7f, 0.3f, Gradient3(p / (5.0f * ripple_m_), seed_ + 10));
    // Sharper crests than troughs.
    const auto wave = noise::CosTurn(x);
    return fade * strength * (0.75f * wave + 0.25f * wave * wave - 0.12f);
  }
  template <typename Vec>
  RealOf<Vec> Shells(const Vec& p, Float8 w) const {
    if (shells_ <= 0) return Splat(0);
    constexpr float kCell = 0.012f;
    const float share = 0.3f * shells_;
    const Float8 fade = Fade(kCell, w);
    if (!Any(fade > 0)) return Splat(share);
    const auto cell = noise::Cells3(p / kCell, seed_ + 12);
    const Float8 size = 0.14f + 0.2f * UnitByte(cell.id, 2);
    const Float8 is = UnitByte(cell.id, 0) < 3.0f * shells_ ? Splat(1) : Splat(0);
    return share + fade * (is * (1.0f - SmoothStep(0.6f * size, size, cell.f1)) - share);
  }

  Vec3f sand_, damp_, shell_, across_;
  float grain_m_, spread_, ripple_m_, depth_m_, wet_, shells_;
};

// Broken rock: beds that lean, joints across them, facets where it split, crystals, veins of quartz
// and lichen on what has lain long.
class Rock final : public Carved<Rock> {
 public:
  explicit Rock(Rng& rng) {
    struct Kind {
      uint32_t light, dark;
    };
    static constexpr std::array<Kind, 7> kKinds = {{{0x8d8983, 0x5f5c58},    // Granite-grey
                                                    {0x55555a, 0x333338},    // Basalt
                                                    {0xb8ad98, 0x8a7f6b},    // Limestone
                                                    {0x9a7a62, 0x6b4f40},    // Ironstone
                                                    {0x7d8078, 0x4f544c},    // Greenstone
                                                    {0xa69a94, 0x6f625f},    // Gneiss
                                                    {0x7a736f, 0x4d4846}}};  // Schist
    const Kind& kind = rng.Pick(kKinds);
    light_ = VaryColor(rng, SrgbColor(kind.light), 0.12, 0.03);
    dark_ = VaryColor(rng, SrgbColor(kind.dark), 0.12, 0.03);
    weathered_ = Mix(light_, SrgbColor(0xbab3a6), 0.45f);
    vein_ = SrgbColor(0xd6d0c6);
    lichen_color_ = SrgbColor(rng.Bernoulli(0.5) ? 0xa3a88c : 0xb8963f);
    facet_m_ = Draw(rng, 0.02, 0.05);
    bed_m_ = Draw(rng, 0.008, 0.03);
    bedding_ = rng.Bernoulli(0.6) ? Draw(rng, 0.3, 0.9) : 0.1f;
    up_ = Vec3f{Draw(rng, -0.5, 0.5), Draw(rng, -0.5, 0.5), 1.0f}.normalized();
    veins_ = rng.Bernoulli(0.4) ? Draw(rng, 0.4, 0.9) : 0.0f;
    lichen_ = rng.Bernoulli(0.5) ? Draw(rng, 0.4, 0.9) : 0.0f;
    crystal_m_ = Draw(rng, 0.0009, 0.0025);
    sparkle_ = Draw(rng, 0.15, 0.5);
    seed_ = DrawSeed(rng);
  }

  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 beds = Beds(p, w);
    const Float8 mottle = Fbm3(p, 0.05f, 5, w, seed_ + 2, 0.62f);
    Float8 crystal = Splat(0);
    const Float8 fine = Fade(2.0f * crystal_m_, w);
    if (Any(fine > 0)) {
      const noise::Cell8 cell = noise::Cells3(p / crystal_m_, seed_ + 4);
      crystal = fine * sparkle_ * (UnitByte(cell.id, 0) - 0.5f);
    }
    const Float8 joint = Joints(p, w);
    // Stones of one rock differ in tone, and each has patches; what faces up has weathered paler.
    const Float8 tone = Fbm3(p, 3.5f, 2, w, seed_ + 40) + 0.7f * Fbm3(p, 0.5f, 3, w, seed_ + 43);
    const Float8 weathered = SmoothStep(0.1f, 0.9f, Facing(point.normal, up_)) *
                             Saturate(0.45f + 0.6f * mottle + 0.3f * tone);
    Vec3x8 color = Mix(dark_, light_, Saturate(0.5f + 0.4f * bedding_ * beds + 0.35f * mottle));
    color = Mix(color * (1.0f + 0.45f * tone), weathered_, 0.5f * weathered);
    // Dust lies in the hollows.
    color *= (1.0f + crystal) * (1.0f + 0.12f * Facets(p, w)) * (1.0f - 0.6f * joint);
    color = Mix(color, vein_, Veins(p, w));
    const Float8 lichen =
        lichen_ *
        noise::Above(noise::Fbm3Filtered(p, 0.035f, 5, w, seed_ + 7, 0.62f), 0.34f, 0.07f);
    return {.base_color = Albedo(Mix(color, lichen_color_ * (1.0f + 0.2f * mottle), lichen)),
            .roughness = Saturate(0.82f + 0.12f * mottle + 0.1f * lichen),
            .specular = Splat(0.35f)};
  }

  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto& p = point.texture_m;
    return 0.16f * facet_m_ * Facets(p, w) + 0.06f * bedding_ * bed_m_ * Beds(p, w) -
           0.06f * facet_m_ * Joints(p, w) + 7e-4f * Fbm3(p, 0.012f, 4, w, seed_ + 9, 0.6f);
  }

 private:
  // Layers of uneven thickness; about [-1, 1].
  template <typename Vec>
  RealOf<Vec> Beds(const Vec& p, Float8 w) const {
    const auto level = Along(up_, p) + 0.25f * bed_m_ * Gradient3(p / (4.0f * bed_m_), seed_ + 11);
    RealOf<Vec> sum = Splat(0);
    float wavelength = 3.0f * bed_m_, strength = 1;
    for (uint32_t i = 0; i < 3; ++i) {
      sum += strength * Fade(wavelength, w) *
             noise::Gradient2(level / wavelength, RealOf<Vec>(Splat(0.5f)), seed_ + 12 + i);
      wavelength *= 0.4f;
      strength *= 0.7f;
    }
    return 1.6f * sum;
  }
  // Broken faces: folds of two sizes, sharp along their ridges; about [-1, 1].
  template <typename Vec>
  RealOf<Vec> Facets(const Vec& p, Float8 w) const {
    const Vec q = p + up_ * (0.8f * Along(up_, p));
    RealOf<Vec> sum = Splat(0);
    float wavelength = 3.5f * facet_m_, strength = 1;
    for (uint32_t i = 0; i < 3; ++i) {
      const Float8 fade = Fade(wavelength, w);
      if (!Any(fade > 0)) break;
      sum += strength * fade * (0.5f - 2.0f * Abs(Gradient3(q / wavelength, seed_ + 20 + i)));
      wavelength *= 0.45f;
      strength *= 0.55f;
    }
    return sum;
  }
  // Cracks that open and close along their way; 1 within.
  template <typename Vec>
  RealOf<Vec> Joints(const Vec& p, Float8 w) const {
    const float wave = 5.0f * facet_m_, width = 0.035f;
    const Float8 fade = Fade(wave, w);
    if (!Any(fade > 0)) return Splat(0);
    const Vec q = p + Vec3f(0.5f * up_) * Along(up_, p);
    const auto n = Gradient3(q / wave, seed_ + 30) +
                   0.22f * Fade(0.25f * wave, w) * Gradient3(q * (4.0f / wave), seed_ + 31);
    const auto open = SmoothStep(-0.1f, 0.4f, Gradient3(p / (1.3f * wave), seed_ + 32));
    const Float8 wide = width + 2.0f * w / wave;
    return fade * open * (width / wide) * (1.0f - SmoothStep(0.2f * wide, wide, Abs(n)));
  }
  Float8 Veins(const Vec3x8& p, Float8 w) const {
    if (veins_ <= 0) return Splat(0);
    constexpr float kWave = 0.13f, kWidth = 0.03f;
    const Float8 n = Fbm3(p, kWave, 3, w, seed_ + 17, 0.5f);
    const Float8 wide = kWidth + 2.0f * w / kWave;
    return veins_ * (kWidth / wide) * (1.0f - SmoothStep(0.3f * wide, wide, Abs(n))) *
           Fade(kWave, w) * SmoothStep(-0.3f, 0.3f, Gradient3(p / 0.2f, seed_ + 18));
  }

  Vec3f light_, dark_, weathered_, vein_, lichen_color_, up_;
  float facet_m_, bed_m_, bedding_, veins_, lichen_, crystal_m_, sparkle_;
};

}  // namespace

void AddGroundMaterials(MaterialList& list) {
  const MaterialTags dull = {.diffuse = true};
  list.push_back(Entry<Rock>("Rock", "rock", dull));
  list.push_back(Entry<Sand>("Sand", "sand", dull));
}

}  // namespace parallax
