// Family `skin`: what light goes into: skin and wax. The scattering inside is approximated by the
// renderer's `subsurface`.
#include <array>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

// A net of fine creases, pores where they cross, blood under it, freckles and a film of oil.
class Skin final : public Carved<Skin> {
 public:
  explicit Skin(Rng& rng) {
    static constexpr std::array<uint32_t, 8> kSkins = {0xe8c0a6, 0xd9a98a, 0xc48f6c, 0xa9744f,
                                                       0x80553a, 0x5a3a2a, 0xe3cfc4, 0xb8a79c};
    skin_ = VaryColor(rng, SrgbColor(rng.Pick(kSkins)), 0.08, 0.03);
    blood_ = Albedo(skin_.cwiseProduct(Vec3f(1.02f, 0.62f, 0.6f)));
    pale_ = Albedo(Mix(skin_, Vec3f::Constant(0.8f), 0.2f));
    freckle_ = Albedo(skin_.cwiseProduct(Vec3f(0.6f, 0.42f, 0.33f)));
    // People's skin, or the hide of something bigger.
    hide_ = rng.Bernoulli(0.4);
    crease_m_ = hide_ ? Draw(rng, 0.004, 0.011) : Draw(rng, 0.0012, 0.0026);
    flush_ = Draw(rng, 0.1, 0.4);
    freckles_ = rng.Bernoulli(0.5) ? Draw(rng, 0.15, 0.6) : 0.0f;
    oil_ = Draw(rng, 0.35, 0.55);
    vein_ = rng.Bernoulli(0.5) ? Draw(rng, 0.1, 0.3) : 0.0f;
    seed_ = DrawSeed(rng);
  }

  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 crease = Creases(p, w);
    const Float8 flush =
        flush_ * noise::Above(noise::Fbm3Filtered(p, 0.06f, 5, w, seed_ + 2, 0.6f), 0.0f, 0.5f);
    const Float8 mottle = Fbm3(p, 0.012f, 4, w, seed_ + 3, 0.6f);
    const Float8 shine = Fbm3(p, 0.04f, 3, w, seed_ + 4);
    Vec3x8 color = Mix(Mix(skin_, pale_, Saturate(0.5f + 0.45f * mottle)), blood_, flush);
    color = Mix(color, Albedo(skin_.cwiseProduct(Vec3f(0.72f, 0.86f, 0.9f))), Veins(p, w));
    color = Mix(color, freckle_, Freckles(p, w));
    return {.base_color = Albedo(
                color * (1.0f - (hide_ ? 0.4f : 0.25f) * (crease - kMeanCrease) + 0.04f * mottle)),
            .roughness = Saturate(oil_ + 0.12f * shine + 0.1f * (crease - kMeanCrease)),
            .specular = Splat(0.4f),
            .sheen = Splat(0.12f),
            .subsurface = Splat(0.75f)};
  }

  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto& p = point.texture_m;
    return -0.09f * crease_m_ * Creases(p, w) + 6e-5f * Fbm3(p, 0.01f, 3, w, seed_ + 6);
  }

 private:
  static constexpr float kMeanCrease = 0.42f;

  // Polygons of two sizes, the coarse creases deeper; 1 in a crease.
  template <typename Vec>
  RealOf<Vec> Creases(const Vec& p, Float8 w) const {
    return kMeanCrease + 0.6f * Net(p, 2.2f * crease_m_, w, seed_) +
           0.4f * Net(p, crease_m_, w, seed_ + 1);
  }
  // Less its mean.
  template <typename Vec>
  static RealOf<Vec> Net(const Vec& p, float size_m, Float8 w, uint32_t seed) {
    const Float8 fade = Fade(size_m, w);
    if (!Any(fade > 0)) return Splat(0);
    const Vec q = VecOf(p.x / size_m, p.y / (1.25f * size_m), p.z / size_m);
    const auto shake = 0.2f * Gradient3(q, seed + 9);
    const auto cell = noise::Cells3(q + VecOf(shake, shake, -shake), seed);
    return fade * (1.0f - SmoothStep(0.0f, 0.4f, cell.f2 - cell.f1) - kMeanCrease);
  }
  Float8 Freckles(const Vec3x8& p, Float8 w) const {
    if (freckles_ <= 0) return Splat(0);
    constexpr float kCell = 0.009f;
    const float share = 0.05f * freckles_;
    const Float8 fade = Fade(kCell, w);
    if (!Any(fade > 0)) return Splat(share);
    const noise::Cell8 cell = noise::Cells3(p / kCell, seed_ + 12);
    const Float8 is = UnitByte(cell.id, 0) < freckles_ ? Splat(1) : Splat(0);
    const Float8 size = 0.12f + 0.22f * UnitByte(cell.id, 1);
    return share +
           fade * (0.7f * is * (1.0f - SmoothStep(0.4f * size, 1.2f * size, cell.f1)) - share);
  }
  Float8 Veins(const Vec3x8& p, Float8 w) const {
    if (vein_ <= 0) return Splat(0);
    const Float8 n = Fbm3(p, 0.07f, 2, w, seed_ + 14);
    const Float8 wide = 0.1f + w / 0.035f;
    return vein_ * (0.1f / wide) * (1.0f - SmoothStep(0.0f, wide, Abs(n))) * Fade(0.07f, w);
  }

  Vec3f skin_, blood_, pale_, freckle_;
  bool hide_;
  float crease_m_, flush_, freckles_, oil_, vein_;
};

// Candle wax and soap: light in the depth, a bloom on the surface, marks of hands and small pits.
class Wax final : public Carved<Wax> {
 public:
  explicit Wax(Rng& rng) {
    static constexpr std::array<uint32_t, 10> kWaxes = {0xefe6d0, 0xe0c994, 0xd9a64a, 0xa8322a,
                                                        0x3f5f7d, 0x5f7a66, 0xd9a9a0, 0xcfc6dd,
                                                        0x7a2f3a, 0xf0ede6};
    wax_ = VaryColor(rng, SrgbColor(rng.Pick(kWaxes)), 0.08, 0.04);
    cloud_ = Albedo(wax_ * Draw(rng, 1.1, 1.35));
    bloom_ = Draw(rng, 0.1, 0.6);
    layer_m_ = Draw(rng, 0.02, 0.06);
    layers_ = rng.Bernoulli(0.35) ? Draw(rng, 0.3, 0.8) : 0.0f;
    second_ = VaryColor(rng, SrgbColor(rng.Pick(kWaxes)), 0.08, 0.04);
    roughness_ = Draw(rng, 0.25, 0.5);
    pits_ = Draw(rng, 0.1, 0.5);
    seed_ = DrawSeed(rng);
  }

  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 cloud =
        noise::Above(noise::Fbm3Filtered(p, 0.05f, 5, w, seed_ + 1, 0.6f), 0.05f, 0.35f);
    const Float8 bloom =
        bloom_ * noise::Above(noise::Fbm3Filtered(p, 0.02f, 5, w, seed_ + 2, 0.65f), 0.2f, 0.3f);
    Vec3x8 base = wax_;
    if (layers_ > 0) {
      // Poured in layers of two colours that ran into each other.
      const Float8 bend = 0.35f * layer_m_ * Gradient3(p / (1.5f * layer_m_), seed_ + 3);
      const Float8 wave = noise::CosTurn((p.x + bend) / layer_m_) * Fade(layer_m_, w);
      base = Mix(wax_, second_, layers_ * (0.5f + 0.5f * wave));
    }
    const Float8 pit = Pits(p, w);
    return {
        .base_color = Albedo(
            Mix(Mix(base, cloud_, 0.6f * cloud), Vec3f(Vec3f::Constant(0.85f)), 0.07f * bloom) *
            (1.0f - 0.15f * pit)),
        .roughness = Saturate(roughness_ + 0.3f * bloom + 0.06f * Fbm3(p, 0.03f, 3, w, seed_ + 5)),
        .specular = Splat(0.45f),
        .subsurface = Splat(0.85f)};
  }

  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto& p = point.texture_m;
    return 2.5e-4f * Fbm3(p, 0.03f, 3, w, seed_ + 6) - 2e-4f * Pits(p, w);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Pits(const Vec& p, Float8 w) const {
    constexpr float kCell = 0.006f;
    const float share = 0.03f * pits_;
    const Float8 fade = Fade(kCell, w);
    if (!Any(fade > 0)) return Splat(share);
    const auto cell = noise::Cells3(p / kCell, seed_ + 8);
    const Float8 is = UnitByte(cell.id, 0) < pits_ ? Splat(1) : Splat(0);
    const Float8 size = 0.1f + 0.15f * UnitByte(cell.id, 1);
    return share + fade * (is * (1.0f - SmoothStep(0.3f * size, size, cell.f1)) - share);
  }

  Vec3f wax_, cloud_, second_;
  float bloom_, layer_m_, layers_, roughness_, pits_;
};

}  // namespace

void AddSkinMaterials(MaterialList& list) {
  list.push_back(Entry<Skin>("Skin", "skin", {}));
  list.push_back(Entry<Wax>("Wax", "skin", {}));
}

}  // namespace parallax
