// Family `plastic`: moulded colours; the mould's grain and years of use are what one sees.
#include <array>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

Vec3f DrawPigment(Rng& rng) {
  static constexpr std::array<uint32_t, 18> kPigments = {
      0xe6e6e3, 0xc9cbcc, 0x8f9396, 0x2b2c2e, 0x17181a, 0xb8322a, 0xd9772b, 0xe3b93a, 0x4f8f46,
      0x2c6e5b, 0x2f6fb0, 0x23407d, 0x7a3f86, 0xd887a0, 0x6bb1b8, 0xd9c8a8, 0x7d5b3f, 0x9bbf7a};
  return VaryColor(rng, SrgbColor(rng.Pick(kPigments)), 0.12, 0.06);
}

struct PlasticStyle {
  double roughness_low, roughness_high;
  double grain_low_mm, grain_high_mm;  // Grain of the mould.
  double depth_um;                     // Depth of that grain.
};

// Colours of machines' housings: black to white, seldom a colour.
Vec3f DrawHousing(Rng& rng) {
  static constexpr std::array<uint32_t, 10> kHousings = {0x141416, 0x1c1d1f, 0x232427, 0x2e3033,
                                                         0x44474b, 0x6d7074, 0xb9bbbc, 0xdcdcd9,
                                                         0xebeae6, 0x2a2f3d};
  return VaryColor(rng, SrgbColor(rng.Pick(kHousings)), 0.08, 0.02);
}

class Plastic final : public Carved<Plastic> {
 public:
  Plastic(Rng& rng, const PlasticStyle& style, Vec3f (*pigment)(Rng&) = DrawPigment) {
    pigment_ = pigment(rng);
    roughness_ = Draw(rng, style.roughness_low, style.roughness_high);
    grain_m_ = Draw(rng, style.grain_low_mm, style.grain_high_mm) * 1e-3f;
    depth_m_ = Float(style.depth_um) * Draw(rng, 0.6, 1.4) * 1e-6f;
    mottle_ = Draw(rng, 0.06, 0.13);
    wear_ = Draw(rng, 0.02, 0.12);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Float8 n = noise::Fbm3(point.texture_m, 0.08f, 5, w, seed_, 0.6f);
    // Handling polishes rough plastic and dulls smooth plastic, in patches.
    const Float8 worn =
        noise::SmoothStep(0.1f, 0.8f, noise::Fbm3(point.texture_m, 0.05f, 3, w, seed_ + 6));
    return {.base_color = Albedo(pigment_ * (1.0f + mottle_ * n)),
            .roughness = Saturate(roughness_ + wear_ * worn * (roughness_ > 0.4f ? -1.0f : 1.0f))};
  }
  auto HeightOf(const auto& point) const {
    return depth_m_ * noise::Fbm3(point.texture_m, grain_m_, 2, point.footprint_m, seed_ + 9);
  }

 private:
  Vec3f pigment_;
  float roughness_, grain_m_, depth_m_, mottle_, wear_;
};

// Two or three colours that ran into each other in the press: bowls, toys, recycled boards.
class MarbledPlastic final : public Carved<MarbledPlastic> {
 public:
  explicit MarbledPlastic(Rng& rng) {
    first_ = DrawPigment(rng);
    second_ = DrawPigment(rng);
    swirl_m_ = Draw(rng, 0.03, 0.12);
    roughness_ = Draw(rng, 0.15, 0.45);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Vec3x8 bend(noise::Gradient3(p / swirl_m_, seed_),
                      noise::Gradient3(p / swirl_m_, seed_ + 1),
                      noise::Gradient3(p / swirl_m_, seed_ + 2));
    const Float8 n = noise::Fbm3(p + bend * (0.9f * swirl_m_), swirl_m_, 4, w, seed_ + 3, 0.55f);
    const Float8 t = noise::SmoothStep(-0.35f, 0.35f, n);
    return {.base_color = Albedo(Mix(first_, second_, t)), .roughness = Splat(roughness_)};
  }
  auto HeightOf(const auto& point) const {
    return 6e-6f * noise::Fbm3(point.texture_m, 0.006f, 2, point.footprint_m, seed_ + 9);
  }

 private:
  Vec3f first_, second_;
  float swirl_m_, roughness_;
};

// Foam rubber and neoprene: dull, with open cells.
class FoamRubber final : public Carved<FoamRubber> {
 public:
  explicit FoamRubber(Rng& rng) {
    color_ = Desaturate(DrawPigment(rng), 0.4f) * 0.8f;
    pore_m_ = Draw(rng, 0.0018, 0.005);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 pore = Pore(point.texture_m, point.footprint_m);
    const Float8 n = noise::Fbm3(point.texture_m, 0.06f, 3, point.footprint_m, seed_ + 2);
    return {.base_color = Albedo(color_ * (1.0f - 0.55f * pore + 0.1f * n)),
            .roughness = Splat(0.9f),
            .specular = Splat(0.2f)};
  }
  auto HeightOf(const auto& point) const {
    return -0.2f * pore_m_ * Pore(point.texture_m, point.footprint_m);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Pore(const Vec& p, Float8 w) const {
    const Float8 fade = Fade(1.5f * pore_m_, w);
    if (!Any(fade > 0)) return Splat(0.1f);
    const auto cell = noise::Cells3(p / pore_m_, seed_);
    const Float8 radius = 0.2f + 0.35f * noise::UnitByte(cell.id, 0);
    const auto pore = (1.0f - noise::SmoothStep(0.5f * radius, radius, cell.f1)) *
                      noise::SmoothStep(0.0f, 0.2f, cell.f2 - cell.f1);
    return 0.1f + fade * (pore - 0.1f);
  }

  Vec3f color_;
  float pore_m_;
};

}  // namespace

void AddPlasticMaterials(MaterialList& list) {
  const MaterialTags dull = {.diffuse = true};
  list.push_back(Entry<FoamRubber>("FoamRubber", "plastic", dull));
  list.push_back(Entry<Plastic>("GlossyPlastic", "plastic", {}, PlasticStyle{0.08, 0.2, 5, 15, 6}));
  list.push_back(Entry<Plastic>("HousingPlastic", "plastic", dull,
                                PlasticStyle{0.32, 0.55, 0.6, 1.4, 14}, DrawHousing));
  list.push_back(Entry<MarbledPlastic>("MarbledPlastic", "plastic", {}));
  list.push_back(
      Entry<Plastic>("MattePlastic", "plastic", dull, PlasticStyle{0.45, 0.65, 0.8, 1.8, 10}));
  list.push_back(
      Entry<Plastic>("RoughPlastic", "plastic", dull, PlasticStyle{0.6, 0.8, 1.5, 3.5, 45}));
}

}  // namespace parallax
