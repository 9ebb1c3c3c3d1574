// Families `sand` and `rock`: what lies on the ground and what stands out of it.
#include <array>

#include "worker/materials/families.h"
#include "worker/materials/surface.h"

namespace parallax {
namespace {

using noise::Fade;
using noise::Fbm3;
using noise::Gradient3;
using noise::Saturate;
using noise::SmoothStep;
using noise::UnitByte;

// Grains of quartz, each its own tint, in ripples that the wind left; darker where it is damp, here
// and there a bit of shell.
class Sand final : public Material {
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

  SurfaceSample Evaluate(const SurfacePoint& point) const override {
    const float w = point.footprint_m;
    const Vec3f& p = point.texture_m;
    const float fade = Fade(2.0f * grain_m_, w);
    float tone = 0, dark = 0, lit = kMeanTop;
    if (fade > 0) {
      const noise::Cell cell = noise::Cells3(p / grain_m_, seed_);
      tone = fade * spread_ * (UnitByte(cell.id, 0) - 0.5f);
      dark = fade * (UnitByte(cell.id, 1) > 0.94f ? 0.55f : 0.0f) + (1 - fade) * 0.033f;
      lit += fade * (Grain(cell) - kMeanTop);
    } else {
      dark = 0.033f;
    }
    const float damp =
        wet_ * noise::Above(noise::Fbm3Filtered(p, 0.16f, 5, w, seed_ + 3, 0.6f), 0.12f, 0.12f);
    const float broad = Fbm3(p, 0.07f, 4, w, seed_ + 4, 0.6f);
    // Coarse, light grains gather on the crests.
    const float crest = Ripples(p, w);
    Vec3f color = Mix(sand_, damp_, damp);
    color *= (1.0f + tone) * (0.62f + 0.6f * lit) * (1.0f + 0.1f * broad + 0.14f * crest) *
             (1.0f - dark);
    SurfaceSample out;
    out.base_color = Albedo(Mix(color, shell_, Shells(p, w)));
    out.roughness = Saturate(0.95f - 0.35f * damp);
    out.specular = 0.3f;
    return out;
  }

  float Height(const SurfacePoint& point) const override {
    const float w = point.footprint_m;
    const Vec3f& p = point.texture_m;
    const float fade = Fade(2.0f * grain_m_, w);
    return (fade > 0 ? 0.2f * grain_m_ * fade * Grain(noise::Cells3(p / grain_m_, seed_)) : 0.0f) +
           depth_m_ * Ripples(p, w) + 4e-4f * Fbm3(p, 0.025f, 3, w, seed_ + 6) +
           6e-4f * Shells(p, w);
  }

 private:
  static constexpr float kMeanTop = 0.55f;

  static float Grain(const noise::Cell& cell) {
    return Saturate(1.0f - 0.9f * cell.f1 * cell.f1) * SmoothStep(0.0f, 0.3f, cell.f2 - cell.f1);
  }
  // Crests that wander, fork and die out; about [-1, 1].
  float Ripples(const Vec3f& p, float w) const {
    const float fade = Fade(ripple_m_, w);
    if (fade <= 0) return 0;
    const float wander = 0.9f * Gradient3(p / (2.6f * ripple_m_), seed_ + 8) +
                         0.35f * Gradient3(p / (0.9f * ripple_m_), seed_ + 9);
    const float x = across_.dot(p) / ripple_m_ + wander;
    const float strength = SmoothStep(-0.7f, 0.3f, Gradient3(p / (5.0f * ripple_m_), seed_ + 10));
    // Sharper crests than troughs.
    const float wave = noise::CosTurn(x);
    return fade * strength * (0.75f * wave + 0.25f * wave * wave - 0.12f);
  }
  float Shells(const Vec3f& p, float w) const {
    if (shells_ <= 0) return 0;
    constexpr float kCell = 0.012f;
    const float share = 0.3f * shells_, fade = Fade(kCell, w);
    if (fade <= 0) return share;
    const noise::Cell cell = noise::Cells3(p / kCell, seed_ + 12);
    const float size = 0.14f + 0.2f * UnitByte(cell.id, 2);
    const float is = UnitByte(cell.id, 0) < 3.0f * shells_ ? 1.0f : 0.0f;
    return share + fade * (is * (1.0f - SmoothStep(0.6f * size, size, cell.f1)) - share);
  }

  Vec3f sand_, damp_, shell_, across_;
  float grain_m_, spread_, ripple_m_, depth_m_, wet_, shells_;
  uint32_t seed_;
};

// Broken rock: beds that lean, joints across them, facets where it split, crystals, veins of quartz
// and lichen on what has lain long.
class Rock final : public Material {
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
                                                    {0x7a6f7a, 0x4d4450}}};  // Schist
    const Kind& kind = rng.Pick(kKinds);
    light_ = VaryColor(rng, SrgbColor(kind.light), 0.12, 0.03);
    dark_ = VaryColor(rng, SrgbColor(kind.dark), 0.12, 0.03);
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

  SurfaceSample Evaluate(const SurfacePoint& point) const override {
    const float w = point.footprint_m;
    const Vec3f& p = point.texture_m;
    const float beds = Beds(p, w);
    const float mottle = Fbm3(p, 0.05f, 5, w, seed_ + 2, 0.62f);
    float crystal = 0;
    const float fine = Fade(2.0f * crystal_m_, w);
    if (fine > 0) {
      const noise::Cell cell = noise::Cells3(p / crystal_m_, seed_ + 4);
      crystal = fine * sparkle_ * (UnitByte(cell.id, 0) - 0.5f);
    }
    const float joint = Joints(p, w);
    Vec3f color = Mix(dark_, light_, Saturate(0.5f + 0.4f * bedding_ * beds + 0.35f * mottle));
    // Dust lies in the hollows.
    color *= (1.0f + crystal) * (1.0f + 0.12f * Facets(p, w)) * (1.0f - 0.6f * joint);
    color = Mix(color, vein_, Veins(p, w));
    const float lichen =
        lichen_ *
        noise::Above(noise::Fbm3Filtered(p, 0.035f, 5, w, seed_ + 7, 0.62f), 0.34f, 0.07f);
    SurfaceSample out;
    out.base_color = Albedo(Mix(color, lichen_color_ * (1.0f + 0.2f * mottle), lichen));
    out.roughness = Saturate(0.82f + 0.12f * mottle + 0.1f * lichen);
    out.specular = 0.35f;
    return out;
  }

  float Height(const SurfacePoint& point) const override {
    const float w = point.footprint_m;
    const Vec3f& p = point.texture_m;
    return 0.16f * facet_m_ * Facets(p, w) + 0.06f * bedding_ * bed_m_ * Beds(p, w) -
           0.06f * facet_m_ * Joints(p, w) + 7e-4f * Fbm3(p, 0.012f, 4, w, seed_ + 9, 0.6f);
  }

 private:
  // Layers of uneven thickness; about [-1, 1].
  float Beds(const Vec3f& p, float w) const {
    const float level = up_.dot(p) + 0.25f * bed_m_ * Gradient3(p / (4.0f * bed_m_), seed_ + 11);
    float sum = 0, wavelength = 3.0f * bed_m_, strength = 1;
    for (uint32_t i = 0; i < 3; ++i) {
      sum += strength * Fade(wavelength, w) *
             noise::Gradient2(level / wavelength, 0.5f, seed_ + 12 + i);
      wavelength *= 0.4f;
      strength *= 0.7f;
    }
    return 1.6f * sum;
  }
  // Broken faces: folds of two sizes, sharp along their ridges; about [-1, 1].
  float Facets(const Vec3f& p, float w) const {
    const Vec3f q = p + up_ * (0.8f * up_.dot(p));
    float sum = 0, wavelength = 3.5f * facet_m_, strength = 1;
    for (uint32_t i = 0; i < 3; ++i) {
      const float fade = Fade(wavelength, w);
      if (fade <= 0) break;
      sum += strength * fade * (0.5f - 2.0f * std::fabs(Gradient3(q / wavelength, seed_ + 20 + i)));
      wavelength *= 0.45f;
      strength *= 0.55f;
    }
    return sum;
  }
  // Cracks that open and close along their way; 1 within.
  float Joints(const Vec3f& p, float w) const {
    const float wave = 5.0f * facet_m_, width = 0.035f, fade = Fade(wave, w);
    if (fade <= 0) return 0;
    const Vec3f q = p + 0.5f * up_ * up_.dot(p);
    const float n = Gradient3(q / wave, seed_ + 30) +
                    0.22f * Fade(0.25f * wave, w) * Gradient3(q * (4.0f / wave), seed_ + 31);
    const float open = SmoothStep(-0.1f, 0.4f, Gradient3(p / (1.3f * wave), seed_ + 32));
    const float wide = width + 2.0f * w / wave;
    return fade * open * (width / wide) * (1.0f - SmoothStep(0.2f * wide, wide, std::fabs(n)));
  }
  float Veins(const Vec3f& p, float w) const {
    if (veins_ <= 0) return 0;
    constexpr float kWave = 0.13f, kWidth = 0.03f;
    const float n = Fbm3(p, kWave, 3, w, seed_ + 17, 0.5f);
    const float wide = kWidth + 2.0f * w / kWave;
    return veins_ * (kWidth / wide) * (1.0f - SmoothStep(0.3f * wide, wide, std::fabs(n))) *
           Fade(kWave, w) * SmoothStep(-0.3f, 0.3f, Gradient3(p / 0.2f, seed_ + 18));
  }

  Vec3f light_, dark_, vein_, lichen_color_, up_;
  float facet_m_, bed_m_, bedding_, veins_, lichen_, crystal_m_, sparkle_;
  uint32_t seed_;
};

}  // namespace

void AddGroundMaterials(MaterialList& list) {
  const MaterialTags dull = {.diffuse = true};
  list.push_back(Entry<Rock>("Rock", "rock", dull));
  list.push_back(Entry<Sand>("Sand", "sand", dull));
}

}  // namespace parallax
