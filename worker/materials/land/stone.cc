// Family `stone`: marble, granite, slate, sandstone. Solid: the veins run through the body.
#include <array>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

// Veins are where warped noise passes through zero: strong ones, and a finer net between.
class Marble final : public Carved<Marble> {
 public:
  explicit Marble(Rng& rng) {
    struct Kind {
      uint32_t ground, cloud, vein;
    };
    static constexpr std::array<Kind, 7> kKinds = {
        {{0xe6e3dd, 0xcfcdc9, 0x7d7c7e},    // Carrara
         {0xe8e2d4, 0xd9ccb2, 0xa98b55},    // Calacatta gold
         {0x26272a, 0x33353a, 0xd0cdc5},    // Marquina
         {0x2f4a3d, 0x3f6150, 0xb9c7b8},    // Verde
         {0xd8bfa4, 0xc7a583, 0x94603f},    // Rosa
         {0x6a4a3a, 0x7f5b47, 0xd8c3ab},    // Emperador
         {0xb7bdc1, 0x9ca4aa, 0x585f66}}};  // Bardiglio
    const Kind& kind = rng.Pick(kKinds);
    ground_ = VaryColor(rng, SrgbColor(kind.ground), 0.06, 0.02);
    cloud_ = VaryColor(rng, SrgbColor(kind.cloud), 0.06, 0.02);
    vein_ = VaryColor(rng, SrgbColor(kind.vein), 0.1, 0.03);
    scale_m_ = Draw(rng, 0.12, 0.3);
    thickness_ = Draw(rng, 0.04, 0.13);
    strength_ = Draw(rng, 0.55, 0.95);
    roughness_ = rng.Bernoulli(0.7) ? Draw(rng, 0.06, 0.16) : Draw(rng, 0.3, 0.45);
    bedding_ = Vec3f{Draw(rng, 0.3, 1), Draw(rng, -1, 1), Draw(rng, 0.3, 1)}.normalized();
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    // Veins run along the bedding: the body is stretched along a slanted direction.
    const Vec3x8 p = point.texture_m - bedding_ * (0.62f * Along(bedding_, point.texture_m));
    const Float8 bend = Fbm3(p, scale_m_, 4, w, seed_, 0.6f);
    const Float8 twist = Fbm3(p, 0.6f * scale_m_, 3, w, seed_ + 31, 0.6f);
    const Vec3x8 q = p + Vec3x8(bend, twist, bend - twist) * (0.16f * scale_m_);
    const Float8 big =
        Vein(Fbm3(q, 0.8f * scale_m_, 4, w, seed_ + 7, 0.5f), thickness_, scale_m_, w);
    const Float8 small = Vein(Fbm3(q, 0.3f * scale_m_, 2, w, seed_ + 17, 0.5f), 0.6f * thickness_,
                              0.3f * scale_m_, w);
    const Float8 cloud = SmoothStep(-0.5f, 0.6f, bend + 0.4f * twist);
    // A vein comes and goes along its way.
    const Float8 present = SmoothStep(-0.35f, 0.45f, twist);
    const Float8 crystal = 0.05f * Fade(2e-3f, w) * Gradient3(point.texture_m * 700.0f, seed_ + 3);
    Vec3x8 color = Mix(ground_, cloud_, cloud);
    color = Mix(color, vein_,
                Saturate(strength_ * (big * (0.35f + 0.65f * present) + 0.4f * small * present)));
    return {.base_color = Albedo(color * (1.0f + crystal)),
            .roughness = Saturate(roughness_ * (1.0f + 0.5f * big)),
            .subsurface = Splat(0.5f)};
  }
  auto HeightOf(const auto& point) const {
    return 1.2e-5f * Fbm3(point.texture_m, 0.03f, 3, point.footprint_m, seed_ + 5);
  }

 private:
  static Float8 Vein(Float8 n, float width, float wavelength_m, Float8 w) {
    // |grad n| is about 2 a wavelength: a footprint widens the line and thins it by the same
    // factor.
    const Float8 wide = width + Min(2.0f * w / wavelength_m, 0.85f);
    const Float8 line = 1.0f - SmoothStep(0.0f, wide, Abs(n));
    return line * width / wide;
  }

  Vec3f ground_, cloud_, vein_, bedding_;
  float scale_m_, thickness_, strength_, roughness_;
};

// Grains of feldspar, quartz and mica, in two sizes.
class Granite final : public Carved<Granite> {
 public:
  explicit Granite(Rng& rng) {
    struct Kind {
      std::array<uint32_t, 4> grains;
    };
    static constexpr std::array<Kind, 6> kKinds = {{{{0xd9d5cf, 0xa7a5a3, 0x6b6a6b, 0x2a2a2c}},
                                                    {{0xc98f7c, 0xb2766a, 0x8a8584, 0x2d2a2b}},
                                                    {{0x33373b, 0x1f2124, 0x565c63, 0x8f959a}},
                                                    {{0xc9b48f, 0xa98c5f, 0x6e5a41, 0x2f2822}},
                                                    {{0x55606a, 0x7f8c95, 0x2d333a, 0xb9c0c4}},
                                                    {{0x6b2f2b, 0x8d4a41, 0x332625, 0xb5a39a}}}};
    const Kind& kind = rng.Pick(kKinds);
    mean_.setZero();
    for (size_t i = 0; i < 4; ++i) {
      grains_[i] = VaryColor(rng, SrgbColor(kind.grains[i]), 0.08, 0.03);
      mean_ += grains_[i] * kShare[i];
    }
    grain_m_ = Draw(rng, 0.002, 0.006);
    roughness_ = rng.Bernoulli(0.65) ? Draw(rng, 0.08, 0.2) : Draw(rng, 0.45, 0.65);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Float8 fade = Fade(1.6f * grain_m_, w);
    const Float8 drift = Fbm3(point.texture_m, 0.12f, 3, w, seed_ + 4);
    Vec3x8 color = mean_;
    Float8 mica = Splat(0);
    if (Any(fade > 0)) {
      // Ragged borders: the query is shaken a little.
      const Vec3x8 q = point.texture_m / grain_m_;
      const Float8 shake = 0.35f * Gradient3(q * 2.3f, seed_ + 1);
      const noise::Cell8 coarse = Cells3(q + Vec3x8(shake, -shake, shake), seed_);
      const Float8 pick = UnitByte(coarse.id, 0);
      const Float8 fine = Gradient3(q * 3.7f, seed_ + 2);
      const Mask8 dark = (fine > 0.42f) | (pick >= 0.88f);
      mica = dark ? Splat(1) : Splat(0);
      Vec3x8 kind = grains_[3];
      kind = Select(~dark, grains_[2], kind);
      kind = Select(~dark & (pick < 0.72f), grains_[1], kind);
      kind = Select(~dark & (pick < 0.42f), grains_[0], kind);
      const Vec3x8 grain = kind * (0.85f + 0.3f * UnitByte(coarse.id, 1) + 0.14f * fine +
                                   0.12f * Gradient3(q * 9.0f, seed_ + 5));
      color = Mix(mean_, grain, fade);
    }
    return {.base_color = Albedo(color * (1.0f + 0.1f * drift)),
            .roughness = Saturate(roughness_ * (1.0f + 0.5f * fade * mica))};
  }
  auto HeightOf(const auto& point) const {
    return 2e-5f * Fbm3(point.texture_m, grain_m_, 3, point.footprint_m, seed_ + 6) *
           (roughness_ > 0.4f ? 6.0f : 1.0f);
  }

 private:
  static constexpr std::array<float, 4> kShare = {0.40f, 0.28f, 0.15f, 0.17f};
  std::array<Vec3f, 4> grains_;
  Vec3f mean_;
  float grain_m_, roughness_;
};

// Split along its layers: flat terraces with small cliffs between.
class Slate final : public Carved<Slate> {
 public:
  explicit Slate(Rng& rng) {
    stone_ = PickColor(rng, {0x4a5057, 0x3a3d42, 0x5a6460, 0x6a5a5c, 0x7a7f80}, 0.15, 0.03);
    rust_ = VaryColor(rng, SrgbColor(0x8a6a4a), 0.1, 0.04);
    rusty_ = rng.Bernoulli(0.4) ? Draw(rng, 0.2, 0.6) : 0.0f;
    roughness_ = Draw(rng, 0.45, 0.65);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 level = Terraces(p, w);
    const Float8 n = Fbm3(p, 0.09f, 5, w, seed_ + 3, 0.6f);
    const Float8 stain = rusty_ * SmoothStep(0.0f, 0.7f, Fbm3(p, 0.2f, 4, w, seed_ + 9));
    return {.base_color = Albedo(Mix(stone_ * (0.85f + 0.25f * level + 0.28f * n), rust_, stain)),
            .roughness = Saturate(roughness_ * (1.0f + 0.2f * n)),
            .specular = Splat(0.45f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    return 1.6e-3f * Terraces(point.texture_m, w) +
           1e-4f * Fbm3(point.texture_m, 0.01f, 3, w, seed_ + 5);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Terraces(const Vec& p, Float8 w) const {
    const auto n = 1.6f * Fbm3(p, 0.17f, 4, w, seed_, 0.5f) + 2.0f;
    const Float8 step = Floor(ValueOf(n));
    const auto rise = n - step;
    return (step + SmoothStep(0.42f, 0.58f, rise) - 2.0f) * 0.5f + 0.15f * (n - 2.0f);
  }

  Vec3f stone_, rust_;
  float rusty_, roughness_;
};

// Beds of sand across z, each with its own tint; gritty.
class Sandstone final : public Carved<Sandstone> {
 public:
  explicit Sandstone(Rng& rng) {
    sand_ = PickColor(rng, {0xd0b48a, 0xc79a6b, 0xb9876a, 0xcfc3a8, 0xa8967c}, 0.12, 0.04);
    dark_ = sand_.cwiseProduct(Vec3f(0.72f, 0.62f, 0.55f));
    bed_m_ = Draw(rng, 0.008, 0.04);
    banding_ = Draw(rng, 0.2, 0.9);
    tilt_x_ = Draw(rng, -0.15, 0.15);
    tilt_y_ = Draw(rng, -0.15, 0.15);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Float8 bed = Bed(point.texture_m, w);
    const Float8 n = Fbm3(point.texture_m, 0.1f, 6, w, seed_ + 2, 0.6f);
    const Float8 grain = Fade(1.2e-3f, w) * Gradient3(point.texture_m * 900.0f, seed_ + 8);
    return {.base_color = Albedo(Mix(sand_, dark_, Saturate(0.35f + banding_ * bed)) *
                                 (1.0f + 0.16f * n + 0.16f * grain)),
            .roughness = Splat(0.9f),
            .specular = Splat(0.3f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    return 3e-4f * banding_ * Bed(point.texture_m, w) +
           1e-4f * Fade(1.2e-3f, w) * Gradient3(point.texture_m * 900.0f, seed_ + 8) +
           2.5e-4f * Fbm3(point.texture_m, 0.02f, 3, w, seed_ + 12);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Bed(const Vec& p, Float8 w) const {
    const auto t = p.z + tilt_x_ * p.x + tilt_y_ * p.y + 0.6f * bed_m_ * Gradient3(p * 6.0f, seed_);
    return Fade(bed_m_, w) *
               Gradient3(0.5f * t / bed_m_, RealOf<Vec>(Splat(0.5f)), t / bed_m_, seed_ + 1) +
           0.6f * Fade(0.3f * bed_m_, w) *
               Gradient3(RealOf<Vec>(Splat(0.4f)), t / bed_m_, 3.4f * t / bed_m_, seed_ + 5);
  }

  Vec3f sand_, dark_;
  float bed_m_, banding_, tilt_x_, tilt_y_;
};

}  // namespace

void AddStoneMaterials(MaterialList& list) {
  list.push_back(Entry<Granite>("Granite", "stone", {.floor = true}));
  list.push_back(Entry<Marble>("Marble", "stone", {.floor = true}));
  list.push_back(Entry<Sandstone>("Sandstone", "stone", {.diffuse = true, .walls = true}));
  list.push_back(Entry<Slate>("Slate", "stone", {.diffuse = true, .floor = true}));
}

}  // namespace parallax
