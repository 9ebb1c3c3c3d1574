// Family `forest`, its barks. Slots name these classes; they replace nothing else.
#include <cmath>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/land/forest_parts.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

// Ridges that run along x and join, furrows between (oak, poplar, willow); moss on one side.
class FurrowedBark final : public Carved<FurrowedBark> {
 public:
  explicit FurrowedBark(Rng& rng) {
    bark_ = PickColor(rng, {0x7a6a58, 0x6b5d4f, 0x857868, 0x5f5145, 0x766a60}, 0.12, 0.03);
    deep_ = 0.4f * bark_;
    ridge_m_ = Draw(rng, 0.028, 0.05);
    stretch_ = Draw(rng, 4.5, 8);
    depth_m_ = 0.16f * ridge_m_;
    moss_ = rng.Bernoulli(0.6) ? Draw(rng, 0.3, 0.9) : 0.0f;
    const float turn = Draw(rng, 0, 6.2831853);
    shade_ = Vec3f(std::cos(turn), std::sin(turn), 0.2f).normalized();
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 top = Ridges(p, w);
    const Float8 fibre = Fbm3(Vec3x8(0.3f * p.x, p.y, p.z), 0.012f, 4, w, seed_ + 2, 0.65f);
    const Float8 broad = Fbm3(p, 0.3f, 3, w, seed_ + 3);
    // In the furrows first.
    const Float8 moss = moss_ * Facing(point.normal, shade_) * (1.0f - 0.45f * top) *
                        Above(Fbm3Filtered(p, 0.14f, 6, w, seed_ + 5, 0.68f), 0.02f, 0.4f);
    const Vec3x8 color = Mix(deep_, bark_, top) * (1.0f + 0.25f * fibre + 0.2f * broad);
    return {.base_color = Albedo(Mix(color, kMossGreen * (1.0f + 0.4f * fibre), moss)),
            .roughness = Splat(0.95f),
            .specular = Splat(0.2f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto& p = point.texture_m;
    return depth_m_ * Ridges(p, w) +
           6e-4f * Fbm3(VecOf(0.3f * p.x, p.y, p.z), 0.012f, 3, w, seed_ + 2, 0.6f);
  }

 private:
  // 1 on the ridges, 0 in the furrows.
  template <typename Vec>
  RealOf<Vec> Ridges(const Vec& p, Float8 w) const {
    constexpr float kMean = 0.6f;
    const Float8 fade = Fade(ridge_m_, w);
    if (!Any(fade > 0)) return Splat(kMean);
    const Vec q = VecOf(p.x / stretch_, p.y, p.z) / ridge_m_;
    const auto n = Gradient3(q, seed_) + 0.35f * Gradient3(q * 2.3f, seed_ + 1);
    // Cross cracks break the ridges into long plates.
    const auto cross = Gradient3(VecOf(p.x, 0.4f * p.y, 0.4f * p.z) / (1.6f * ridge_m_), seed_ + 4);
    const auto top =
        SmoothStep(0.02f, 0.26f, Abs(n)) * (0.55f + 0.45f * SmoothStep(0.0f, 0.16f, Abs(cross)));
    return kMean + fade * (top - kMean);
  }

  Vec3f bark_, deep_, shade_;
  float ridge_m_, stretch_, depth_m_, moss_;
};

// White and papery, with dark dashes across and black scars.
class BirchBark final : public Carved<BirchBark> {
 public:
  explicit BirchBark(Rng& rng) {
    white_ = VaryColor(rng, SrgbColor(0xd8d2c6), 0.07, 0.02);
    tan_ = VaryColor(rng, SrgbColor(0xb59a80), 0.1, 0.03);
    black_ = SrgbColor(0x2a2622);
    scars_ = Draw(rng, 0.16, 0.34);
    dash_m_ = Draw(rng, 0.007, 0.012);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 n = Fbm3(Vec3x8(2.5f * p.x, p.y, p.z), 0.12f, 4, w, seed_ + 2, 0.6f);
    const Float8 dark = Saturate(0.85f * Dashes(p, w) + Scars(p, w));
    const Vec3x8 paper = Mix(white_, tan_, Saturate(0.22f + 0.6f * n));
    return {.base_color = Albedo(Mix(paper * (1.0f + 0.12f * n), Vec3x8(black_), dark)),
            .roughness = Saturate(0.6f + 0.3f * dark),
            .specular = Splat(0.3f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto& p = point.texture_m;
    return 1.2e-3f * Scars(p, w) + 4e-4f * Dashes(p, w) +
           5e-4f * Fbm3(VecOf(2.5f * p.x, p.y, p.z), 0.04f, 3, w, seed_ + 2, 0.55f);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Dashes(const Vec& p, Float8 w) const {
    const auto n =
        Fbm3Filtered(VecOf(5.0f * p.x, p.y, p.z), 5.0f * dash_m_, 2, w * 3.0f, seed_ + 4);
    return 0.9f * Above(n, 0.34f, 0.06f);
  }
  template <typename Vec>
  RealOf<Vec> Scars(const Vec& p, Float8 w) const {
    const auto n = Fbm3Filtered(VecOf(1.7f * p.x, p.y, p.z), 0.17f, 5, w, seed_ + 7, 0.6f);
    return Above(n, 0.62f - scars_, 0.07f);
  }

  Vec3f white_, tan_, black_;
  float scars_, dash_m_;
};

// Plates of scales in layers, reddish where they broke off (pine, spruce, larch).
class ConiferBark final : public Carved<ConiferBark> {
 public:
  explicit ConiferBark(Rng& rng) {
    bark_ = PickColor(rng, {0x7d6350, 0x6f5a4b, 0x84705f, 0x8a6248, 0x665549}, 0.12, 0.03);
    red_ = VaryColor(rng, SrgbColor(0x97603f), 0.12, 0.04);
    plate_m_ = Draw(rng, 0.022, 0.045);
    stretch_ = Draw(rng, 2.2, 4.2);
    red_share_ = Draw(rng, 0.1, 0.42);
    lichen_ = rng.Bernoulli(0.5) ? Draw(rng, 0.2, 0.6) : 0.0f;
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    Bits8 id;
    const Float8 top = Plates(p, w, &id);
    const Float8 fade = Fade(plate_m_, w);
    const Float8 n = Fbm3(Vec3x8(0.5f * p.x, p.y, p.z), 0.02f, 4, w, seed_ + 2, 0.65f);
    const Float8 red = red_share_ * (0.5f + fade * (UnitByte(id, 1) - 0.5f));
    const Float8 green =
        lichen_ * Above(Fbm3Filtered(p, 0.1f, 5, w, seed_ + 5, 0.6f), 0.2f, 0.15f) * top;
    Vec3x8 color = Mix(Vec3x8(bark_), Vec3x8(red_), red);
    color *=
        (0.46f + 0.58f * top) * (1.0f + 0.4f * n) * (1.0f + 0.2f * fade * (UnitByte(id, 0) - 0.5f));
    return {.base_color = Albedo(Mix(color, SrgbColor(0x8f9a80), green)),
            .roughness = Splat(0.92f),
            .specular = Splat(0.25f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto& p = point.texture_m;
    Bits8 id;
    return 0.11f * plate_m_ * Plates(p, w, &id) +
           5e-4f * Fbm3(VecOf(0.5f * p.x, p.y, p.z), 0.02f, 3, w, seed_ + 2, 0.6f);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Plates(const Vec& p, Float8 w, Bits8* id) const {
    constexpr float kMean = 0.55f;
    *id = Bits8{};
    const Float8 fade = Fade(plate_m_, w);
    if (!Any(fade > 0)) return Splat(kMean);
    const Vec q = VecOf(p.x / stretch_, p.y, p.z) / plate_m_;
    const auto shake =
        0.4f * Gradient3(q * 1.4f, seed_ + 9) + 0.22f * Gradient3(q * 4.1f, seed_ + 10);
    const auto cell = noise::Cells3(q + VecOf(shake, shake, -shake), seed_);
    *id = cell.id;
    const auto top = SmoothStep(0.0f, 0.42f, cell.f2 - cell.f1);
    return kMean + fade * (top - kMean);
  }

  Vec3f bark_, red_;
  float plate_m_, stretch_, red_share_, lichen_;
};

// Thin and grey, lenticels across, blotches of lichen (young maple, beech, twigs).
class SmoothBark final : public Carved<SmoothBark> {
 public:
  explicit SmoothBark(Rng& rng) {
    bark_ = PickColor(rng, {0x7d766c, 0x6b5f52, 0x5f5348, 0x8a8478, 0x6a5a4a}, 0.1, 0.03);
    lichen_ = Draw(rng, 0.2, 0.7);
    lichen_color_ = SrgbColor(rng.Bernoulli(0.6) ? 0xa8aa98 : 0x93a07c);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 n = Fbm3(Vec3x8(1.6f * p.x, p.y, p.z), 0.06f, 5, w, seed_ + 2, 0.6f);
    const Float8 spots =
        lichen_ * Above(Fbm3Filtered(p, 0.07f, 5, w, seed_ + 5, 0.6f), 0.22f, 0.08f);
    const Vec3x8 color = Vec3x8(bark_) * (1.0f + 0.3f * n) * (1.0f - 0.35f * Lenticels(p, w));
    return {.base_color = Albedo(Mix(color, Vec3x8(lichen_color_), spots)),
            .roughness = Splat(0.85f),
            .specular = Splat(0.3f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto& p = point.texture_m;
    return 7e-4f * Lenticels(p, w) + 6e-4f * Fbm3(VecOf(1.6f * p.x, p.y, p.z), 0.03f, 4, w, seed_);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Lenticels(const Vec& p, Float8 w) const {
    const auto n = Fbm3Filtered(VecOf(3.5f * p.x, p.y, p.z), 0.022f, 2, w * 2.5f, seed_ + 4);
    return Above(n, 0.36f, 0.08f);
  }

  Vec3f bark_, lichen_color_;
  float lichen_;
};

}  // namespace

void AddBarkMaterials(MaterialList& list) {
  const MaterialTags own = {.diffuse = true, .any_object = false};
  list.push_back(Entry<BirchBark>("BirchBark", "forest", own));
  list.push_back(Entry<ConiferBark>("ConiferBark", "forest", own));
  list.push_back(Entry<FurrowedBark>("FurrowedBark", "forest", own));
  list.push_back(Entry<SmoothBark>("SmoothBark", "forest", own));
}

}  // namespace parallax
