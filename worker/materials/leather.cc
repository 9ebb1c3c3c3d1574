// Family `leather`: grain in cells, creases where it bent, suede.
#include <array>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

Vec3f DrawHide(Rng& rng) {
  static constexpr std::array<uint32_t, 12> kHides = {0x7a4a2c, 0x5a3420, 0x8f5f3a, 0xb08050,
                                                      0x3a2620, 0x26211f, 0x6e2a26, 0xd0b996,
                                                      0xc9c2b6, 0x2f3a33, 0x2a3442, 0x8a7a68};
  return VaryColor(rng, SrgbColor(rng.Pick(kHides)), 0.12, 0.05);
}

class Leather final : public Carved<Leather> {
 public:
  explicit Leather(Rng& rng) {
    hide_ = DrawHide(rng);
    deep_ = hide_ * Draw(rng, 0.35, 0.6);
    worn_ = Mix(hide_, SrgbColor(0xd2b48c), Draw(rng, 0.1, 0.4));
    grain_m_ = Draw(rng, 0.0016, 0.0042);
    roughness_ = Draw(rng, 0.32, 0.6);
    wear_ = Draw(rng, 0.0, 0.5);
    crease_ = Draw(rng, 0.2, 1.0);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 groove = Groove(p, w);
    const Float8 broad = Fbm3(p, 0.14f, 5, w, seed_ + 2, 0.55f);
    const Float8 worn =
        wear_ * noise::Above(noise::Fbm3Filtered(p, 0.2f, 4, w, seed_ + 5), 0.2f, 0.3f);
    const Float8 crease = crease_ * Crease(p, w);
    Vec3x8 color = Mix(hide_ * (1.0f + 0.13f * broad), worn_, worn);
    color = Mix(color, deep_, Saturate(0.75f * groove + 0.5f * crease));
    return {
        .base_color = Albedo(color),
        .roughness = Saturate(roughness_ * (1.0f + 0.25f * groove + 0.12f * broad - 0.25f * worn)),
        .specular = Splat(0.45f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    return -0.06f * grain_m_ * Groove(point.texture_m, w) -
           2.5e-4f * crease_ * Crease(point.texture_m, w) +
           2e-4f * Fbm3(point.texture_m, 0.03f, 2, w, seed_ + 12);
  }

 private:
  // 1 in the valleys between the grain's cells.
  template <typename Vec>
  RealOf<Vec> Groove(const Vec& p, Float8 w) const {
    const float mean = 0.30f;
    const Float8 fade = Fade(1.4f * grain_m_, w);
    if (!Any(fade > 0)) return Splat(mean);
    const auto cell = noise::Cells3(p / grain_m_, seed_);
    const auto groove = 1.0f - SmoothStep(0.0f, 0.32f, cell.f2 - cell.f1);
    return mean + fade * (groove - mean);
  }
  // Long folds: where slow noise passes through zero.
  template <typename Vec>
  RealOf<Vec> Crease(const Vec& p, Float8 w) const {
    const auto n = Fbm3(VecOf(p.x * 0.6f, p.y, p.z), 0.07f, 3, w, seed_ + 9, 0.6f);
    const Float8 wide = 0.05f + Min(0.85f, 2.0f * w / 0.07f);
    return (0.05f / wide) * (1.0f - SmoothStep(0.0f, wide, Abs(n)));
  }

  Vec3f hide_, deep_, worn_;
  float grain_m_, roughness_, wear_, crease_;
};

class Suede final : public Carved<Suede> {
 public:
  explicit Suede(Rng& rng) {
    hide_ = DrawHide(rng);
    brushed_ = Draw(rng, 0.12, 0.32);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 swipe = Fbm3(Vec3x8(p.x * 0.35f, p.y, p.z), 0.05f, 4, w, seed_, 0.6f);
    const Float8 nap = Fbm3(p, 0.0018f, 2, w, seed_ + 4);
    return {.base_color = Albedo(hide_ * (1.0f + brushed_ * swipe + 0.16f * nap)),
            .roughness = Splat(0.95f),
            .specular = Splat(0.15f),
            .sheen = Splat(0.5f)};
  }
  auto HeightOf(const auto& point) const {
    return 6e-5f * Fbm3(point.texture_m, 0.0018f, 2, point.footprint_m, seed_ + 4);
  }

 private:
  Vec3f hide_;
  float brushed_;
};

// Diamonds sewn into upholstery: pillows between seams.
class QuiltedLeather final : public Carved<QuiltedLeather> {
 public:
  explicit QuiltedLeather(Rng& rng) {
    hide_ = DrawHide(rng);
    cell_m_ = Draw(rng, 0.035, 0.08);
    stretch_ = Draw(rng, 1.0, 1.6);
    puff_m_ = cell_m_ * Draw(rng, 0.04, 0.08);
    roughness_ = Draw(rng, 0.3, 0.5);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Float8 seam = 1.0f - SmoothStep(0.0f, 0.0015f + w, EdgeOf(OnPlane(point)));
    const Float8 fade = Fade(cell_m_, w);
    const Float8 broad = Fbm3(point.texture_m, 0.05f, 6, w, seed_, 0.6f);
    return {.base_color = Albedo(hide_ * ((1.0f + 0.12f * broad) * (1.0f - 0.45f * fade * seam))),
            .roughness = Saturate(roughness_ * (1.0f + 0.2f * broad))};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto t = Saturate(EdgeOf(OnPlane(point)) / (0.35f * cell_m_));
    return puff_m_ * Fade(cell_m_, w) * t * (2.0f - t) +
           4e-5f * Fbm3(point.texture_m, 0.003f, 2, w, seed_ + 3);
  }

 private:
  template <typename Real>
  Real EdgeOf(const PlaneOf8<Real>& plane) const {
    const auto a = plane.u / cell_m_ + plane.v / (stretch_ * cell_m_);
    const auto b = plane.u / cell_m_ - plane.v / (stretch_ * cell_m_);
    const auto x = Abs(noise::Fract(a) - 0.5f), y = Abs(noise::Fract(b) - 0.5f);
    return (0.5f - Max(x, y)) * cell_m_ * 0.75f;
  }

  Vec3f hide_;
  float cell_m_, stretch_, puff_m_, roughness_;
};

}  // namespace

void AddLeatherMaterials(MaterialList& list) {
  list.push_back(Entry<Leather>("Leather", "leather", {}));
  list.push_back(Entry<QuiltedLeather>("QuiltedLeather", "leather", {}));
  list.push_back(Entry<Suede>("Suede", "leather", {.diffuse = true}));
}

}  // namespace parallax
