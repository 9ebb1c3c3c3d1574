// Family `forest`: dead wood, moss, the forest's floor, stones with moss,
// caps of mushrooms. Slots name these classes; they replace nothing else.
#include <array>
#include <cmath>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/land/forest_parts.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

// Barkless wood that weather bleached, cracked along x, rotten brown in places.
class DeadWood final : public Carved<DeadWood> {
 public:
  explicit DeadWood(Rng& rng) {
    wood_ = PickColor(rng, {0x9a9084, 0x8a7a66, 0xa89a86, 0x7d7064}, 0.1, 0.03);
    rot_ = SrgbColor(0x5a4028);
    rotten_ = Draw(rng, 0.1, 0.45);
    crack_m_ = Draw(rng, 0.012, 0.022);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 fibre = Fbm3(Vec3x8(0.08f * p.x, p.y, p.z), 0.012f, 4, w, seed_ + 2, 0.65f);
    const Float8 rot = rotten_ * Above(Fbm3Filtered(p, 0.25f, 5, w, seed_ + 5, 0.6f), 0.05f, 0.3f);
    const Vec3x8 color = Mix(Vec3x8(wood_), Vec3x8(rot_), rot) * (1.0f + 0.3f * fibre);
    return {.base_color = Albedo(color * (1.0f - 0.75f * Cracks(p, w))),
            .roughness = Splat(0.85f),
            .specular = Splat(0.3f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto& p = point.texture_m;
    return -2.5e-3f * Cracks(p, w) +
           4e-4f * Fbm3(VecOf(0.08f * p.x, p.y, p.z), 0.012f, 3, w, seed_ + 2, 0.6f);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Cracks(const Vec& p, Float8 w) const {
    constexpr float kMean = 0.1f;
    const Float8 fade = Fade(crack_m_, w);
    if (!Any(fade > 0)) return Splat(kMean);
    const Vec q = VecOf(0.07f * p.x, p.y, p.z) / crack_m_;
    const auto n = Gradient3(q, seed_) + 0.3f * Gradient3(q * 2.7f, seed_ + 1);
    const auto open = SmoothStep(-0.1f, 0.3f, Gradient3(p / 0.15f, seed_ + 3));
    const auto crack = open * (1.0f - SmoothStep(0.01f, 0.09f, Abs(n)));
    return kMean + fade * (crack - kMean);
  }

  Vec3f wood_, rot_;
  float rotten_, crack_m_;
};

// A log's sawn end: rings about the line y = z = 0, rays, checks that opened as it dried.
class EndGrain final : public Carved<EndGrain> {
 public:
  explicit EndGrain(Rng& rng) {
    wood_ = PickColor(rng, {0xb89468, 0xa37c52, 0xc2a57d, 0x93785c}, 0.1, 0.03);
    late_ = 0.62f * wood_;
    ring_m_ = Draw(rng, 0.0025, 0.006);
    grey_ = Draw(rng, 0.1, 0.7);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 ring = Rings(p, w);
    const Float8 n = Fbm3(p, 0.05f, 5, w, seed_ + 2, 0.6f);
    const Vec3x8 color = Mix(Vec3x8(wood_), Vec3x8(late_), 0.5f + 0.45f * ring);
    const Float8 grey = grey_ * Above(Fbm3Filtered(p, 0.12f, 4, w, seed_ + 4, 0.6f), 0.0f, 0.35f);
    return {.base_color = Albedo(Mix(color, SrgbColor(0x8a857c), grey) * (1.0f + 0.3f * n)),
            .roughness = Splat(0.8f),
            .specular = Splat(0.3f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    return 2e-4f * Rings(point.texture_m, w) +
           3e-4f * Fbm3(point.texture_m, 0.02f, 4, w, seed_ + 2, 0.6f);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Rings(const Vec& p, Float8 w) const {
    const Float8 fade = Fade(ring_m_, w);
    if (!Any(fade > 0)) return Splat(0);
    const auto r =
        Sqrt(p.y * p.y + p.z * p.z + 1e-6f) + 0.9f * ring_m_ * Gradient3(p / 0.07f, seed_);
    return fade * noise::CosTurn(r / ring_m_);
  }

  Vec3f wood_, late_;
  float ring_m_, grey_;
};

// Cushions of moss: soft lumps of tiny shoots, yellow-green on their heights.
class Moss final : public Carved<Moss> {
 public:
  explicit Moss(Rng& rng) {
    tip_ = PickColor(rng, {0x66752e, 0x586b2a, 0x73802f, 0x5a6a38}, 0.12, 0.05);
    deep_ = 0.35f * tip_;
    shoot_m_ = Draw(rng, 0.003, 0.006);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 shoots = Shoots(p, w);
    const Float8 broad = Fbm3(p, 0.09f, 4, w, seed_ + 3, 0.6f);
    return {.base_color = Albedo(Mix(Vec3x8(deep_), Vec3x8(tip_), Saturate(0.25f + shoots)) *
                                 (1.0f + 0.35f * broad)),
            .roughness = Splat(0.95f),
            .specular = Splat(0.15f),
            .sheen = Splat(0.3f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    return 0.5f * shoot_m_ * Shoots(point.texture_m, w) +
           2e-3f * Fbm3(point.texture_m, 0.05f, 3, w, seed_ + 3);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Shoots(const Vec& p, Float8 w) const {
    constexpr float kMean = 0.5f;
    const Float8 fade = Fade(shoot_m_, w);
    if (!Any(fade > 0)) return Splat(kMean);
    const auto f1 = noise::Cells3(p / shoot_m_, seed_).f1;
    return kMean + fade * (1.0f - SmoothStep(0.0f, 0.9f, f1) - kMean);
  }

  Vec3f tip_, deep_;
  float shoot_m_;
};

// Mould, bits of leaves and bark in three sizes, small roots.
class ForestFloor final : public Carved<ForestFloor> {
 public:
  explicit ForestFloor(Rng& rng) {
    earth_ = PickColor(rng, {0x4a382a, 0x3f3024, 0x574330}, 0.12, 0.04);
    leaf_ = VaryColor(rng, SrgbColor(0x8a6540), 0.12, 0.05);
    pale_ = VaryColor(rng, SrgbColor(0xa88c60), 0.1, 0.04);
    bit_m_ = Draw(rng, 0.014, 0.026);
    cover_ = Draw(rng, 0.4, 0.8);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 large = Fade(bit_m_, w), small = Fade(0.4f * bit_m_, w);
    const noise::Cell8 a = noise::Cells3(p / bit_m_, seed_),
                       b = noise::Cells3(p / (0.4f * bit_m_), seed_ + 1);
    const Float8 is = UnitByte(a.id, 0) < cover_ ? Splat(1) : Splat(0);
    const Float8 leaf = cover_ + large * (is - cover_);
    const Float8 tone = UnitByte(a.id, 1);
    const Float8 edge =
        0.75f + 0.25f * (0.7f + large * (SmoothStep(0.0f, 0.2f, a.f2 - a.f1) - 0.7f));
    const Float8 crumb = 1.0f + 0.5f * small * (UnitByte(b.id, 0) - 0.5f);
    const Float8 n = Fbm3(p, 0.12f, 4, w, seed_ + 3, 0.6f);
    const Vec3x8 bit =
        Mix(Vec3x8(leaf_), Vec3x8(pale_), Saturate(2.0f * tone - 1.0f)) * (0.55f + 0.7f * tone);
    // The mean of `bit` over all tones.
    const Vec3x8 mean(0.6167f * leaf_ + 0.2833f * pale_);
    const Vec3x8 litter = Mix(mean, bit, large);
    return {
        .base_color = Albedo(Mix(Vec3x8(earth_) * crumb, litter, leaf) * edge * (1.0f + 0.3f * n)),
        .roughness = Splat(0.92f),
        .specular = Splat(0.2f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto& p = point.texture_m;
    const auto cell = noise::Cells3(p / bit_m_, seed_);
    return 0.12f * bit_m_ * Fade(bit_m_, w) * SmoothStep(0.0f, 0.3f, cell.f2 - cell.f1) +
           1.5e-3f * Fbm3(p, 0.03f, 4, w, seed_ + 3, 0.6f);
  }

 private:
  Vec3f earth_, leaf_, pale_;
  float bit_m_, cover_;
};

// Weathered stone: broken faces, pits, lichen in discs; moss where it looks up.
class MossyRock final : public Carved<MossyRock> {
 public:
  explicit MossyRock(Rng& rng) {
    stone_ = PickColor(rng, {0x8a8680, 0x77736e, 0x9a9284, 0x7d7a74, 0x8f8274}, 0.1, 0.02);
    dark_ = 0.55f * stone_;
    lichen_color_ = SrgbColor(rng.Bernoulli(0.6) ? 0xb5b8a4 : 0xb09a55);
    lichen_ = Draw(rng, 0.3, 0.9);
    moss_ = rng.Bernoulli(0.7) ? Draw(rng, 0.4, 1.0) : 0.0f;
    const float turn = Draw(rng, 0, 6.2831853);
    up_ = Vec3f(0.5f * std::cos(turn), 0.5f * std::sin(turn), 1).normalized();
    facet_m_ = Draw(rng, 0.03, 0.07);
    grain_m_ = Draw(rng, 0.002, 0.004);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 mottle = Fbm3(p, 0.16f, 6, w, seed_ + 2, 0.62f);
    Float8 grain = Splat(0);
    const Float8 fine = Fade(2.0f * grain_m_, w);
    if (Any(fine > 0)) {
      grain = 0.35f * fine * (UnitByte(noise::Cells3(p / grain_m_, seed_ + 4).id, 0) - 0.5f);
    }
    // Lichens keep to some sides of a stone, and let it shine through.
    const Float8 where = SmoothStep(-0.08f, 0.4f, Fbm3(p, 0.55f, 3, w, seed_ + 6, 0.55f));
    const Float8 discs = 0.7f * lichen_ * where *
                         Above(Fbm3Filtered(p, 0.05f, 6, w, seed_ + 7, 0.66f), 0.24f, 0.12f);
    const Float8 wet = SmoothStep(0.45f, 0.85f, Facing(point.normal, up_));
    const Float8 moss =
        moss_ * wet * Above(Fbm3Filtered(p, 0.22f, 6, w, seed_ + 9, 0.62f), 0.02f, 0.14f);
    Vec3x8 color = Mix(Vec3x8(dark_), Vec3x8(stone_), Saturate(0.62f + 0.5f * mottle));
    color = Mix(color * (1.0f + grain + 0.1f * Facets(p, w)), Vec3x8(lichen_color_), discs);
    return {.base_color = Albedo(Mix(color, kMossGreen * (1.0f + 0.6f * mottle), moss)),
            .roughness = Saturate(0.85f + 0.1f * moss),
            .specular = Splat(0.3f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto& p = point.texture_m;
    return 0.08f * facet_m_ * Facets(p, w) + 8e-4f * Fbm3(p, 0.014f, 4, w, seed_ + 3, 0.6f);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Facets(const Vec& p, Float8 w) const {
    RealOf<Vec> sum = Splat(0);
    float wavelength = 3.0f * facet_m_, strength = 1;
    for (uint32_t i = 0; i < 3; ++i) {
      const Float8 fade = Fade(wavelength, w);
      if (!Any(fade > 0)) break;
      sum += strength * fade * (0.5f - 2.0f * Abs(Gradient3(p / wavelength, seed_ + 20 + i)));
      wavelength *= 0.45f;
      strength *= 0.55f;
    }
    return sum;
  }

  Vec3f stone_, dark_, lichen_color_, up_;
  float lichen_, moss_, facet_m_, grain_m_;
};

// Skin of a mushroom's cap or stem: satin, paler patches, fine fibres from the middle.
class MushroomSkin final : public Carved<MushroomSkin> {
 public:
  explicit MushroomSkin(Rng& rng) {
    static constexpr std::array<uint32_t, 6> kSkins = {0x8a5a34, 0xa87a48, 0xc2a878,
                                                       0xa8402c, 0xd0c2a4, 0x6f5040};
    skin_ = VaryColor(rng, SrgbColor(rng.Pick(kSkins)), 0.12, 0.04);
    pale_ = Mix(skin_, SrgbColor(0xe4dac4), 0.55f);
    roughness_ = Draw(rng, 0.3, 0.6);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 n = Fbm3(p, 0.02f, 4, w, seed_, 0.6f);
    const Float8 pale = Above(Fbm3Filtered(p, 0.035f, 4, w, seed_ + 2, 0.6f), 0.15f, 0.25f);
    return {
        .base_color = Albedo(Mix(Vec3x8(skin_), Vec3x8(pale_), 0.6f * pale) * (1.0f + 0.2f * n)),
        .roughness = Saturate(roughness_ + 0.15f * n),
        .subsurface = Splat(0.4f)};
  }
  auto HeightOf(const auto& point) const {
    return 3e-4f * Fbm3(point.texture_m, 0.008f, 3, point.footprint_m, seed_ + 5, 0.6f);
  }

 private:
  Vec3f skin_, pale_;
  float roughness_;
};

}  // namespace

void AddForestMaterials(MaterialList& list) {
  const MaterialTags own = {.diffuse = true, .any_object = false};
  list.push_back(Entry<DeadWood>("DeadWood", "forest", own));
  list.push_back(Entry<EndGrain>("EndGrain", "forest", own));
  list.push_back(Entry<ForestFloor>("ForestFloor", "forest", own));
  list.push_back(Entry<Moss>("Moss", "forest", own));
  list.push_back(Entry<MossyRock>("MossyRock", "forest", own));
  list.push_back(Entry<MushroomSkin>("MushroomSkin", "forest", own));
}

}  // namespace parallax
