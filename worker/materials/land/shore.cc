// Family `shore`: what water is and leaves: still water, ice and old snow, shells, seaweed. Slots
// name these classes; they replace nothing else.
#include "worker/materials/land/shore.h"

#include <array>
#include <cmath>

#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

// A pool's surface: dark, with motes and the ripples that a breath of wind makes.
class StillWater final : public Carved<StillWater> {
 public:
  explicit StillWater(Rng& rng) {
    water_ = PickColor(rng, {0x2c3a34, 0x24343c, 0x3c3a28, 0x1e2c30}, 0.15, 0.05);
    mote_ = SrgbColor(0x8f8a70);
    ripple_m_ = Draw(rng, 0.03, 0.08);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 cloud = Fbm3(p, 0.09f, 4, w, seed_ + 2, 0.6f);
    const Float8 motes = 0.7f * Above(Fbm3Filtered(p, 0.012f, 3, w, seed_ + 3, 0.6f), 0.42f, 0.06f);
    return {.base_color = Albedo(Mix(water_ * (1.0f + 0.4f * cloud), Vec3x8(mote_), motes)),
            .roughness = Splat(0.08f) + 0.5f * motes,
            .specular = Splat(0.255f),
            .ior = Splat(1.333f)};
  }
  auto HeightOf(const auto& point) const {
    return 0.012f * ripple_m_ * Fbm3(point.texture_m, ripple_m_, 3, point.footprint_m, seed_, 0.5f);
  }

 private:
  Vec3f water_, mote_;
  float ripple_m_;
};

// Snow that wind has packed: a crust in scales and low ridges, grains below.
class PackedSnow final : public Carved<PackedSnow> {
 public:
  explicit PackedSnow(Rng& rng) {
    snow_ = VaryColor(rng, Vec3f(0.80f, 0.82f, 0.85f), 0.03, 0.01);
    shade_ = VaryColor(rng, Vec3f(0.56f, 0.63f, 0.72f), 0.05, 0.02);
    crust_m_ = Draw(rng, 0.05, 0.12);
    grain_m_ = Draw(rng, 0.004, 0.008);
    const float turn = Draw(rng, 0, 6.2831853);
    wind_ = Vec3f(std::cos(turn), std::sin(turn), 0);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 broad = Fbm3(p, 2.4f, 4, w, seed_ + 4, 0.6f), crust = Crust(p, w);
    Float8 grain = Splat(0);
    const Float8 fine = Fade(2.0f * grain_m_, w);
    if (Any(fine > 0)) {
      grain = 0.12f * fine * (UnitByte(noise::Cells3(p / grain_m_, seed_ + 6).id, 0) - 0.5f);
    }
    const Float8 lit = Saturate(0.8f + 0.42f * crust + 0.16f * broad);
    return {.base_color = Albedo(Mix(Vec3x8(shade_), Vec3x8(snow_), lit) * (1.0f + grain)),
            .roughness = Splat(0.9f),
            .specular = Splat(0.2f),
            .subsurface = Splat(0.5f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    return 0.05f * crust_m_ * Crust(point.texture_m, w) +
           3e-4f * Fbm3(point.texture_m, 2.5f * grain_m_, 2, w, seed_ + 7, 0.6f);
  }

 private:
  // Scales that overlap along the wind; about [-1, 1].
  template <typename Vec>
  RealOf<Vec> Crust(const Vec& p, Float8 w) const {
    // Longer along the wind.
    const Vec q = p + Vec3f(-0.62f * wind_) * Along(wind_, p);
    RealOf<Vec> sum = Splat(0);
    float wavelength_m = 3.5f * crust_m_, strength = 1;
    for (uint32_t k = 0; k < 4; ++k) {
      const Float8 fade = Fade(wavelength_m, w);
      if (!Any(fade > 0)) break;
      const auto n = Gradient3(q / wavelength_m, seed_ + k);
      // Steep towards the wind, gentle behind.
      sum += strength * fade * (SmoothStep(-0.12f, 0.5f, n) - 0.4f);
      wavelength_m *= 0.45f;
      strength *= 0.6f;
    }
    return sum;
  }

  Vec3f snow_, shade_, wind_;
  float crust_m_, grain_m_;
};

// Ice of the sea or of a glacier: blue in its depth, white with bubbles in layers, cracked; snow on
// what looks up.
class SeaIce final : public Carved<SeaIce> {
 public:
  explicit SeaIce(Rng& rng) {
    blue_ = VaryColor(rng, Vec3f(0.36f, 0.52f, 0.58f), 0.1, 0.04);
    white_ = VaryColor(rng, Vec3f(0.72f, 0.77f, 0.79f), 0.05, 0.02);
    snow_ = Vec3f(0.8f, 0.82f, 0.85f);
    layer_m_ = Draw(rng, 0.05, 0.14);
    facet_m_ = Draw(rng, 0.06, 0.14);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Vec3x8 bent(p.x * 0.2f, p.y * 0.2f, p.z + 0.08f * Fbm3(p, 0.8f, 2, w, seed_ + 3));
    const Float8 layers = Fbm3(bent, layer_m_, 3, w, seed_ + 1, 0.6f);
    const Float8 bubbles = Fbm3(p, 0.035f, 4, w, seed_ + 2, 0.6f);
    const Float8 crack = Cracks(p, w);
    const Float8 white = Saturate(0.45f + 0.7f * layers + 0.5f * bubbles + 0.7f * crack);
    const Float8 up = SmoothStep(0.55f, 0.85f, point.normal.z + 0.25f * bubbles);
    Vec3x8 color = Mix(Vec3x8(blue_), Vec3x8(white_), white);
    color = Mix(color, Vec3x8(snow_) * (1.0f + 0.1f * bubbles), up);
    return {.base_color = Albedo(color),
            .roughness = Saturate(0.28f + 0.3f * white + 0.35f * up),
            .specular = Splat(0.25f),
            .subsurface = Splat(0.6f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    return 0.06f * facet_m_ * Facets(point.texture_m, w) - 2e-3f * Cracks(point.texture_m, w);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Facets(const Vec& p, Float8 w) const {
    RealOf<Vec> sum = Splat(0);
    float wavelength_m = 3 * facet_m_, strength = 1;
    for (uint32_t k = 0; k < 3; ++k) {
      const Float8 fade = Fade(wavelength_m, w);
      if (!Any(fade > 0)) break;
      sum += strength * fade * (0.5f - 2.0f * Abs(Gradient3(p / wavelength_m, seed_ + 20 + k)));
      wavelength_m *= 0.45f;
      strength *= 0.5f;
    }
    return sum;
  }
  template <typename Vec>
  RealOf<Vec> Cracks(const Vec& p, Float8 w) const {
    const float wave_m = 4 * facet_m_, width = 0.03f;
    const Float8 fade = Fade(wave_m, w);
    if (!Any(fade > 0)) return Splat(0);
    const auto n = Gradient3(p / wave_m, seed_ + 30);
    const Float8 wide = width + 2.0f * w / wave_m;
    return fade * (width / wide) * (1.0f - SmoothStep(0.2f * wide, wide, Abs(n)));
  }

  Vec3f blue_, white_, snow_;
  float layer_m_, facet_m_;
};

// Sheets of the sea's litter: each piece its own tint, by the random number in its uv.
class SeaLitter final : public Carved<SeaLitter> {
 public:
  struct Kind {
    std::array<uint32_t, 4> colors;
    float band_m, roughness, specular;
  };
  SeaLitter(Rng& rng, const Kind& kind) : kind_(kind) {
    first_ = VaryColor(rng, SrgbColor(rng.Pick(kind.colors)), 0.12, 0.04);
    last_ = VaryColor(rng, SrgbColor(rng.Pick(kind.colors)), 0.2, 0.06);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Float8 own = Fade(1.0f, point.footprint_uv);
    const Float8 bands = Fbm3(point.texture_m, kind_.band_m, 3, w, seed_, 0.6f);
    const Vec3x8 color = Mix(Vec3x8(first_), Vec3x8(last_), 0.5f + own * (point.u - 0.5f));
    return {.base_color =
                Albedo(color * ((1.0f + 0.45f * bands) * (1.0f + 0.5f * own * (point.v - 0.5f)))),
            .roughness = Saturate(kind_.roughness * (1.0f + 0.3f * bands)),
            .specular = Splat(kind_.specular)};
  }
  auto HeightOf(const auto& point) const {
    return 2e-4f *
           Fbm3(point.texture_m, 0.5f * kind_.band_m, 3, point.footprint_m, seed_ + 4, 0.6f);
  }

 private:
  const Kind kind_;
  Vec3f first_, last_;
};

constexpr SeaLitter::Kind kShell = {{0xe6dccb, 0xcdb79a, 0x7d7f8c, 0xd8b8a4}, 0.006f, 0.4f, 0.45f};
constexpr SeaLitter::Kind kSeaweed = {{0x3a2c1a, 0x4a3a1e, 0x2a2414, 0x44421e}, 0.03f, 0.35f, 0.5f};

}  // namespace

void AddShoreMaterials(MaterialList& list) {
  const MaterialTags own = {.any_object = false}, dull = {.diffuse = true, .any_object = false};
  list.push_back(Entry<PackedSnow>("PackedSnow", "shore", dull));
  list.push_back(Entry<SeaIce>("SeaIce", "shore", own));
  list.push_back(Entry<SeaLitter>("SeaShell", "shore", own, kShell));
  list.push_back(Entry<SeaLitter>("Seaweed", "shore", own, kSeaweed));
  list.push_back(Entry<StillWater>("StillWater", "shore", own));
}

}  // namespace parallax
