// Families `leaf`, `bark`, `soil` and `food`.
#include <array>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

// A midrib along x (v = 0) and side veins that leave it forwards; mottled, waxy or dull.
class Leaf final : public Carved<Leaf> {
 public:
  explicit Leaf(Rng& rng) {
    static constexpr std::array<uint32_t, 9> kLeaves = {
        0x3f6b2f, 0x2f5528, 0x5a7f37, 0x7a8f3f, 0x4a7350, 0x6f8f6a, 0x8a9a4f, 0x9a6a35, 0x7a3f2f};
    blade_ = VaryColor(rng, SrgbColor(rng.Pick(kLeaves)), 0.18, 0.08);
    vein_ = Albedo(Mix(blade_, SrgbColor(0xc9d28a), Draw(rng, 0.25, 0.6)));
    patch_ = VaryColor(rng, Mix(blade_, SrgbColor(0xb5b04f), 0.5f), 0.2, 0.08);
    spacing_m_ = Draw(rng, 0.006, 0.016);
    slant_ = Draw(rng, 0.5, 1.2);
    roughness_ = Draw(rng, 0.3, 0.6);
    mottle_ = Draw(rng, 0.0, 0.45);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 vein = Veins(OnPlane(point), w);
    const Float8 n = Fbm3(p, 0.03f, 5, w, seed_, 0.6f);
    const Float8 aged =
        mottle_ * noise::Above(noise::Fbm3Filtered(p, 0.05f, 4, w, seed_ + 3), 0.3f, 0.5f);
    Vec3x8 color = Mix(blade_ * (1.0f + 0.2f * n), patch_, aged);
    return {.base_color = Albedo(Mix(color, vein_, 0.7f * vein)),
            .roughness = Saturate(roughness_ * (1.0f + 0.2f * n + 0.15f * vein)),
            .specular = Splat(0.4f),
            .subsurface = Splat(0.5f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    return -2.5e-4f * Veins(OnPlane(point), w) +
           1e-4f * Fbm3(point.texture_m, 0.006f, 3, w, seed_ + 6);
  }

 private:
  template <typename Real>
  Real Veins(const PlaneOf8<Real>& plane, Float8 w) const {
    const Real v = Abs(plane.v);
    const Real rib = (1.2e-3f / (1.2e-3f + w)) * (1.0f - SmoothStep(0.6e-3f, 1.6e-3f + w, v));
    const Float8 fade = Fade(spacing_m_, w);
    const Real bend = 2e-3f * Gradient2(plane.u * 60.0f, v * 60.0f, seed_ + 8);
    const Real x = noise::Fract((plane.u - slant_ * v + bend) / spacing_m_);
    const Real d = Abs(x - 0.5f);
    const Float8 wide = 0.09f + w / spacing_m_;
    const float mean = 0.08f;
    const Real side = (0.09f / wide) * (1.0f - SmoothStep(0.0f, wide, d));
    return Max(rib, Real(mean + fade * (0.8f * side - mean)));
  }

  Vec3f blade_, vein_, patch_;
  float spacing_m_, slant_, roughness_, mottle_;
};

// Plates along x with deep cracks between; lichen on some.
class Bark final : public Carved<Bark> {
 public:
  explicit Bark(Rng& rng) {
    bark_ = PickColor(rng, {0x6b5644, 0x54463a, 0x7f7264, 0x8f8577, 0x4a3a2e}, 0.15, 0.04);
    deep_ = bark_ * 0.3f;
    lichen_ = rng.Bernoulli(0.5) ? Draw(rng, 0.2, 0.7) : 0.0f;
    plate_m_ = Draw(rng, 0.012, 0.035);
    stretch_ = Draw(rng, 2.5, 6);
    depth_m_ = plate_m_ * Draw(rng, 0.1, 0.2);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 top = Plates(p, w);
    const Float8 fibre = Fbm3(Vec3x8(0.25f * p.x, p.y, p.z), 0.008f, 4, w, seed_ + 2, 0.65f);
    const Float8 green =
        lichen_ * noise::Above(noise::Fbm3Filtered(p, 0.12f, 5, w, seed_ + 5, 0.6f), 0.2f, 0.2f) *
        top;
    const Vec3x8 color = Mix(deep_, bark_, top) * (1.0f + 0.25f * fibre);
    return {.base_color = Albedo(Mix(color, SrgbColor(0x8f9a78), green)),
            .roughness = Splat(0.95f),
            .specular = Splat(0.2f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto& p = point.texture_m;
    return depth_m_ * Plates(p, w) +
           4e-4f * Fbm3(VecOf(0.25f * p.x, p.y, p.z), 0.008f, 3, w, seed_ + 2, 0.6f);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Plates(const Vec& p, Float8 w) const {
    const float mean = 0.36f;
    const Float8 fade = Fade(plate_m_, w);
    if (!Any(fade > 0)) return Splat(mean);
    const Vec q = VecOf(p.x / stretch_, p.y, p.z) / plate_m_;
    const auto shake = 0.4f * Gradient3(q * 1.7f, seed_ + 9);
    const auto cell = noise::Cells3(q + VecOf(shake, shake, -shake), seed_);
    const auto top = SmoothStep(0.0f, 0.45f, cell.f2 - cell.f1);
    return mean + fade * (top - mean);
  }

  Vec3f bark_, deep_;
  float lichen_, plate_m_, stretch_, depth_m_;
};

// Crumbs in three sizes, bits of straw and grit.
class Soil final : public Carved<Soil> {
 public:
  explicit Soil(Rng& rng) {
    earth_ = PickColor(rng, {0x4a382b, 0x5f4a38, 0x36291f, 0x7a5f48}, 0.15, 0.05);
    grit_ = VaryColor(rng, SrgbColor(0xa89c8a), 0.15, 0.04);
    crumb_m_ = Draw(rng, 0.006, 0.014);
    stones_ = Draw(rng, 0.04, 0.22);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    Bits8 id;
    const Float8 top = Crumbs(point.texture_m, w, &id);
    const Float8 n = Fbm3(point.texture_m, 0.05f, 5, w, seed_ + 3, 0.65f);
    const Float8 fade = Fade(crumb_m_, w);
    const Float8 stone = noise::Lerp(stones_, noise::Unit(id) < stones_ ? 1.0f : 0.0f, fade);
    const Float8 own = 1.0f + 0.5f * fade * (UnitByte(Hash(1, id), 0) - 0.5f);
    return {.base_color = Albedo(Mix(earth_, grit_, stone) *
                                 ((0.45f + 0.8f * top) * own * (1.0f + 0.25f * n))),
            .roughness = Splat(0.95f),
            .specular = Splat(0.25f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    Bits8 id;
    return 0.3f * crumb_m_ * Fade(crumb_m_, w) * Crumbs(point.texture_m, w, &id) +
           8e-4f * Fbm3(point.texture_m, 0.02f, 4, w, seed_ + 3, 0.6f);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Crumbs(const Vec& p, Float8 w, Bits8* id) const {
    const float mean = 0.6f;
    const Float8 fade = Fade(crumb_m_, w);
    *id = Bits8{};
    if (!Any(fade > 0)) return Splat(mean);
    const Vec q = p / crumb_m_;
    const auto shake = 0.3f * Gradient3(q * 2.1f, seed_ + 7);
    const auto cell = noise::Cells3(q + VecOf(shake, -shake, shake), seed_);
    *id = cell.id;
    const auto top =
        Saturate(1.0f - 1.1f * cell.f1 * cell.f1) * SmoothStep(0.0f, 0.2f, cell.f2 - cell.f1);
    return mean + fade * (top - mean);
  }

  Vec3f earth_, grit_;
  float crumb_m_, stones_;
};

// Lawn or moss seen as ground: tufts of blades, lit tips over dark roots.
class Grass final : public Carved<Grass> {
 public:
  explicit Grass(Rng& rng) {
    tip_ = PickColor(rng, {0x5a7a35, 0x456b30, 0x7a8a45, 0x8a8550, 0x3f5f3a}, 0.15, 0.06);
    root_ = Mix(tip_ * 0.35f, SrgbColor(0x3a2f22), 0.4f);
    dry_ = SrgbColor(0xa89a5f);
    blade_m_ = Draw(rng, 0.003, 0.007);
    dryness_ = Draw(rng, 0.0, 0.5);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const PlanePoint8 plane = OnPlane(point);
    const Float8 blades = Blades(plane, w);
    const Float8 broad = Fbm3(point.texture_m, 0.5f, 5, w, seed_ + 3, 0.6f);
    const Float8 dry =
        dryness_ *
        noise::Above(noise::Fbm3Filtered(point.texture_m, 0.25f, 5, w, seed_ + 5), 0.2f, 0.3f);
    return {.base_color = Albedo(Mix(Mix(root_, tip_, Saturate(0.55f + 0.6f * blades)), dry_, dry) *
                                 (1.0f + 0.15f * broad)),
            .roughness = Splat(0.8f),
            .specular = Splat(0.3f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    return 0.35f * blade_m_ * Blades(OnPlane(point), w) +
           2e-3f * Fbm3(point.texture_m, 0.06f, 3, w, seed_ + 8);
  }

 private:
  // Strokes in three directions, over each other.
  template <typename Real>
  Real Blades(const PlaneOf8<Real>& plane, Float8 w) const {
    const Float8 fade = Fade(1.5f * blade_m_, w);
    Real sum = 0.5f * Fade(6.0f * blade_m_, w) *
               Gradient2(plane.u / (4.0f * blade_m_), plane.v / (4.0f * blade_m_), seed_);
    if (!Any(fade > 0)) return sum;
    const Real a = plane.u / blade_m_, b = plane.v / blade_m_;
    const Real c = 0.5f * a + 0.866f * b, d = 0.5f * b - 0.866f * a;
    const Real e = 0.5f * a - 0.866f * b, f = 0.5f * b + 0.866f * a;
    const Real x = Gradient2(a, 0.15f * b, seed_ + 1), y = Gradient2(c, 0.15f * d, seed_ + 2),
               z = Gradient2(e, 0.15f * f, seed_ + 4);
    return sum + 0.8f * fade * (Max(x, Max(y, z)) - 0.25f);
  }

  Vec3f tip_, root_, dry_;
  float blade_m_, dryness_;
};

// River stones or gravel, each its own stone.
class Gravel final : public Carved<Gravel> {
 public:
  explicit Gravel(Rng& rng) {
    stone_ = PickColor(rng, {0x9a938a, 0x7f7a75, 0xb5a890, 0x8a8078}, 0.12, 0.03);
    size_m_ = Draw(rng, 0.012, 0.03);
    spread_ = Draw(rng, 0.3, 0.8);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Float8 fade = Fade(size_m_, w);
    Float8 top = Splat(0.62f), tone = Splat(0), warm = Splat(0);
    if (Any(fade > 0)) {
      const noise::Cell8 cell = At(point.texture_m);
      top += fade * (Top(cell) - 0.62f);
      tone = fade * spread_ * (UnitByte(cell.id, 0) - 0.5f);
      warm = fade * 0.25f * spread_ * (UnitByte(cell.id, 1) - 0.5f);
    }
    const Float8 n = Fbm3(point.texture_m, 0.012f, 4, w, seed_ + 2, 0.6f);
    const Vec3x8 tint(1.0f + warm, Splat(1), 1.0f - warm);
    return {.base_color =
                Albedo(stone_ * tint * ((1.0f + tone) * (0.3f + 0.85f * top) * (1.0f + 0.16f * n))),
            .roughness = Splat(0.75f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    return 0.22f * size_m_ * Stones(point.texture_m, w) +
           1e-4f * Fbm3(point.texture_m, 0.004f, 2, w, seed_ + 2);
  }

 private:
  template <typename Vec>
  noise::CellOf8<Vec> At(const Vec& p) const {
    return noise::Cells3(p / size_m_, seed_, 0.85f);
  }
  template <typename Vec>
  RealOf<Vec> Stones(const Vec& p, Float8 w) const {
    const Float8 fade = Fade(size_m_, w);
    if (!Any(fade > 0)) return Splat(0);
    return fade * Top(At(p));
  }
  template <typename Vec>
  static RealOf<Vec> Top(const noise::CellOf8<Vec>& cell) {
    const auto t = Saturate((cell.f2 - cell.f1) * 1.6f);
    return Sqrt(Max(t * (2.0f - t), Splat(1e-4f))) - 0.01f;
  }

  Vec3f stone_;
  float size_m_, spread_;
};

// ---- Food

// Apples, plums, tomatoes: a blush over a ground, lenticels, a waxy shine.
class FruitSkin final : public Carved<FruitSkin> {
 public:
  explicit FruitSkin(Rng& rng) {
    struct Kind {
      uint32_t ground, blush;
    };
    static constexpr std::array<Kind, 7> kKinds = {{{0xc9b84a, 0xa8322a},
                                                    {0x9ab04a, 0x7f9a3a},
                                                    {0xc23a2a, 0xd9602f},
                                                    {0x5a2f4a, 0x3a2238},
                                                    {0xd9a03a, 0xc7602f},
                                                    {0x4a6b2f, 0x6f8a3a},
                                                    {0xd98f3f, 0xe0b05a}}};
    const Kind& kind = rng.Pick(kKinds);
    ground_ = VaryColor(rng, SrgbColor(kind.ground), 0.1, 0.05);
    blush_ = VaryColor(rng, SrgbColor(kind.blush), 0.1, 0.05);
    dot_ = Albedo(Mix(ground_, SrgbColor(0xe0d6a8), 0.6f));
    roughness_ = Draw(rng, 0.18, 0.4);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 blush = noise::Above(noise::Fbm3Filtered(p, 0.09f, 3, w, seed_), -0.05f, 0.4f);
    const Float8 streak = Fbm3(Vec3x8(p.x, p.y, 0.18f * p.z), 0.008f, 3, w, seed_ + 2, 0.6f);
    Float8 dots = Splat(0.03f);
    const Float8 fade = Fade(0.005f, w);
    if (Any(fade > 0)) {
      const noise::Cell8 cell = noise::Cells3(p / 0.0065f, seed_ + 5);
      dots += fade * (1.0f - SmoothStep(0.05f, 0.13f + w / 0.0065f, cell.f1) - 0.03f);
    }
    return {.base_color = Albedo(Mix(Mix(ground_, blush_, Saturate(blush + 0.35f * streak)), dot_,
                                     0.55f * Saturate(dots)) *
                                 (1.0f + 0.06f * streak)),
            .roughness = Saturate(roughness_ * (1.0f + 0.2f * streak)),
            .subsurface = Splat(0.5f)};
  }
  auto HeightOf(const auto& point) const {
    return 4e-5f * Fbm3(point.texture_m, 0.012f, 2, point.footprint_m, seed_ + 7);
  }

 private:
  Vec3f ground_, blush_, dot_;
  float roughness_;
};

// Oranges and lemons: pits of oil.
class CitrusPeel final : public Carved<CitrusPeel> {
 public:
  explicit CitrusPeel(Rng& rng) {
    peel_ = PickColor(rng, {0xdd8a2a, 0xd9b836, 0x8fa83a, 0xd9703a}, 0.08, 0.04);
    pit_m_ = Draw(rng, 0.0014, 0.0028);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Float8 pit = Pits(point.texture_m, w);
    const Float8 n = Fbm3(point.texture_m, 0.03f, 4, w, seed_ + 2);
    return {.base_color = Albedo(peel_ * (1.0f - 0.3f * pit + 0.12f * n)),
            .roughness = Saturate(0.4f + 0.1f * n),
            .subsurface = Splat(0.4f)};
  }
  auto HeightOf(const auto& point) const {
    return -0.12f * pit_m_ * Pits(point.texture_m, point.footprint_m);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Pits(const Vec& p, Float8 w) const {
    const float mean = 0.35f;
    const Float8 fade = Fade(1.4f * pit_m_, w);
    if (!Any(fade > 0)) return Splat(mean);
    const auto d = noise::Cells3(p / pit_m_, seed_).f1;
    return mean + fade * (1.0f - SmoothStep(0.1f, 0.65f, d) - mean);
  }

  Vec3f peel_;
  float pit_m_;
};

// Crust of bread and biscuits: browned on the heights, floury in the cracks, blisters.
class BreadCrust final : public Carved<BreadCrust> {
 public:
  explicit BreadCrust(Rng& rng) {
    crumb_ = VaryColor(rng, SrgbColor(0xd9b57a), 0.08, 0.04);
    crust_ = VaryColor(rng, SrgbColor(rng.Bernoulli(0.5) ? 0x9a5f2c : 0x70401f), 0.12, 0.05);
    bake_ = Draw(rng, -0.25, 0.25);
    flour_ = rng.Bernoulli(0.5) ? Draw(rng, 0.2, 0.7) : 0.0f;
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 n = Fbm3(p, 0.04f, 6, w, seed_, 0.6f);
    const Float8 brown =
        noise::Above(noise::Fbm3Filtered(p, 0.04f, 6, w, seed_, 0.6f), -bake_, 0.55f);
    const Float8 dust =
        flour_ * noise::Above(noise::Fbm3Filtered(p, 0.05f, 5, w, seed_ + 4, 0.62f), 0.3f, 0.25f);
    return {.base_color = Albedo(Mix(Mix(crumb_, crust_, brown) * (1.0f + 0.08f * n),
                                     Vec3f(0.75f, 0.71f, 0.62f), dust)),
            .roughness = Saturate(0.6f + 0.1f * n + 0.3f * dust),
            .specular = Splat(0.35f)};
  }
  auto HeightOf(const auto& point) const {
    return 8e-4f * Fbm3(point.texture_m, 0.015f, 4, point.footprint_m, seed_, 0.55f);
  }

 private:
  Vec3f crumb_, crust_;
  float bake_, flour_;
};

}  // namespace

void AddNatureMaterials(MaterialList& list) {
  const MaterialTags dull = {.diffuse = true};
  list.push_back(Entry<Bark>("Bark", "bark", dull));
  list.push_back(Entry<BreadCrust>("BreadCrust", "food", dull));
  list.push_back(Entry<CitrusPeel>("CitrusPeel", "food", {}));
  list.push_back(Entry<FruitSkin>("FruitSkin", "food", {}));
  list.push_back(Entry<Grass>("Grass", "soil", dull));
  list.push_back(Entry<Gravel>("Gravel", "soil", dull));
  list.push_back(Entry<Leaf>("Leaf", "leaf", {}));
  list.push_back(Entry<Soil>("Soil", "soil", dull));
}

}  // namespace parallax
