// Family `paint`: rolled wall paint, trowelled plaster, brushed lacquer for furniture.
#include <array>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

constexpr std::array<uint32_t, 18> kWallColors = {
    0xeae7df, 0xe4ddd0, 0xdcd3c2, 0xd8d9d6, 0xcfcac0, 0xc4bdb0, 0xb8b3a9, 0xd9c9b4, 0xc9cfc4,
    0xb3bfae, 0xb7c4cb, 0x93a7b3, 0xd6c1b6, 0xc79f8c, 0xdac9a0, 0x8a9a84, 0x6d7f8a, 0x5c6a63};

Vec3f DrawWallColor(Rng& rng, bool ceiling) {
  if (ceiling) return VaryColor(rng, SrgbColor(0xe9e7e1), 0.03, 0.015);
  return VaryColor(rng, SrgbColor(rng.Pick(kWallColors)), 0.06, 0.03);
}

// The stipple of a roller: soft dots a few millimetres apart, a little denser in the roller's
// lanes.
class WallPaint final : public Carved<WallPaint> {
 public:
  WallPaint(Rng& rng, bool ceiling) {
    color_ = DrawWallColor(rng, ceiling);
    nap_m_ = Draw(rng, 0.0025, 0.006);
    depth_m_ = Draw(rng, 6e-5, 1.6e-4);
    lane_m_ = Draw(rng, 0.18, 0.25);
    roughness_ = rng.Bernoulli(0.75) ? Draw(rng, 0.7, 0.9) : Draw(rng, 0.4, 0.55);
    blotch_ = Draw(rng, 0.02, 0.05);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const PlanePoint8 plane = OnPlane(point);
    const Float8 lane = Fade(lane_m_, w) * Gradient2(plane.u / lane_m_, 0.4f * plane.v, seed_ + 1);
    const Float8 blotch = Fbm3(point.texture_m, 0.4f, 5, w, seed_ + 2, 0.55f);
    const Float8 dust = Fbm3(point.texture_m, 0.025f, 3, w, seed_ + 7);
    return {.base_color =
                Albedo(color_ * (1.0f + blotch_ * blotch + 0.5f * blotch_ * lane + 0.025f * dust)),
            .roughness = Saturate(roughness_ * (1.0f + 0.08f * blotch + 0.05f * dust)),
            .specular = Splat(0.4f)};
  }
  auto HeightOf(const auto& point) const {
    return depth_m_ * Fbm3(point.texture_m, nap_m_, 2, point.footprint_m, seed_) +
           2e-4f * Fbm3(point.texture_m, 0.15f, 2, point.footprint_m, seed_ + 4);
  }

 private:
  Vec3f color_;
  float nap_m_, depth_m_, lane_m_, roughness_, blotch_;
};

// Strokes of a trowel: arcs that overlap, ridges where they end; clouds of lighter and darker lime.
class Plaster final : public Carved<Plaster> {
 public:
  Plaster(Rng& rng) {
    color_ = DrawWallColor(rng, false);
    stroke_m_ = Draw(rng, 0.10, 0.28);
    depth_m_ = Draw(rng, 2e-4, 8e-4);
    cloud_ = Draw(rng, 0.06, 0.18);
    roughness_ = Draw(rng, 0.6, 0.9);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Float8 cloud = Fbm3(point.texture_m, 0.35f, 6, w, seed_ + 2, 0.6f);
    const Float8 stroke = Strokes(OnPlane(point), w);
    const Float8 grit = Fbm3(point.texture_m, 0.004f, 2, w, seed_ + 9);
    return {.base_color = Albedo(color_ * (1.0f + cloud_ * (cloud + 0.5f * stroke) + 0.04f * grit)),
            .roughness = Saturate(roughness_ * (1.0f - 0.15f * stroke)),
            .specular = Splat(0.4f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    return depth_m_ * Strokes(OnPlane(point), w) +
           6e-5f * Fbm3(point.texture_m, 0.004f, 2, w, seed_ + 9);
  }

 private:
  // Long noise along directions that turn slowly: what a hand leaves.
  template <typename Real>
  Real Strokes(const PlaneOf8<Real>& plane, Float8 w) const {
    const auto turn =
        0.35f * Gradient2(plane.u / stroke_m_ * 0.7f, plane.v / stroke_m_ * 0.7f, seed_);
    const auto c = noise::CosTurn(turn), s = noise::CosTurn(turn - 0.25f);
    const auto a = (c * plane.u + s * plane.v) / stroke_m_,
               b = (c * plane.v - s * plane.u) / stroke_m_;
    auto sum = 0.7f * Fade(0.5f * stroke_m_, w) * Gradient2(a, 2.2f * b, seed_ + 3);
    sum += 0.3f * Fade(0.12f * stroke_m_, w) * Gradient2(2.0f * a, 7.0f * b, seed_ + 4);
    sum += 0.07f * Fade(0.03f * stroke_m_, w) * Gradient2(4.0f * a, 34.0f * b, seed_ + 5);
    return sum;
  }

  Vec3f color_;
  float stroke_m_, depth_m_, cloud_, roughness_;
};

// Furniture paint: the brush's hairs along x, worn to the ground at random edges on some.
class LacquerPaint final : public Carved<LacquerPaint> {
 public:
  explicit LacquerPaint(Rng& rng) {
    static constexpr std::array<uint32_t, 12> kLacquers = {0xe8e5dd, 0xdedbd2, 0x2a2c2e, 0x39434a,
                                                           0x4a6a5c, 0x2f4a63, 0x8fa9a6, 0xb8a78d,
                                                           0x7c2f2a, 0xd2b25f, 0xa9b8a0, 0x6d4a3a};
    color_ = VaryColor(rng, SrgbColor(rng.Pick(kLacquers)), 0.08, 0.04);
    wood_ = VaryColor(rng, SrgbColor(0xa98358), 0.15, 0.05);
    roughness_ = Draw(rng, 0.2, 0.5);
    worn_ = rng.Bernoulli(0.3) ? Draw(rng, 0.0, 0.2) : -1.0f;
    depth_m_ = Draw(rng, 8e-6, 3e-5);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Float8 hairs = Hairs(point.texture_m, w);
    const Float8 n = Fbm3(point.texture_m, 0.12f, 4, w, seed_ + 2);
    const Vec3x8 paint = color_ * (1.0f + 0.035f * hairs + 0.05f * n);
    const Float8 bare = Bare(point.texture_m, w);
    return {.base_color = Albedo(Mix(paint, wood_ * (1.0f + 0.25f * hairs), bare)),
            .roughness = Saturate(noise::Lerp(roughness_ * (1.0f + 0.15f * n), 0.7f, bare))};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    return depth_m_ * Hairs(point.texture_m, w) - 8e-5f * Bare(point.texture_m, w);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Hairs(const Vec& p, Float8 w) const {
    auto sum =
        0.8f * Fade(4e-3f, w) * noise::Gradient3(p.x * 6.0f, p.y * 260.0f, p.z * 260.0f, seed_);
    sum +=
        0.6f * Fade(15e-3f, w) * noise::Gradient3(p.x * 2.0f, p.y * 70.0f, p.z * 70.0f, seed_ + 1);
    return sum;
  }
  template <typename Vec>
  RealOf<Vec> Bare(const Vec& p, Float8 w) const {
    if (worn_ < 0) return Splat(0);
    return noise::Above(noise::Fbm3Filtered(p, 0.07f, 5, w, seed_ + 5, 0.62f), 0.76f - worn_,
                        0.04f);
  }

  Vec3f color_, wood_;
  float roughness_, worn_, depth_m_;
};

}  // namespace

void AddWallMaterials(MaterialList& list) {
  list.push_back(Entry<WallPaint>("CeilingPaint", "paint",
                                  {.diffuse = true, .ceiling = true, .any_object = false}, true));
  list.push_back(Entry<LacquerPaint>("LacquerPaint", "paint", {}));
  list.push_back(
      Entry<Plaster>("Plaster", "paint", {.diffuse = true, .walls = true, .ceiling = true}));
  list.push_back(Entry<WallPaint>("WallPaint", "paint",
                                  {.diffuse = true, .walls = true, .ceiling = true}, false));
}

}  // namespace parallax
