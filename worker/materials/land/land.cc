// Family `land`: bedded rock, sand of deserts, snow, rock of caves, skins of desert plants. Slots
// and biomes name these classes; they replace nothing else.
#include <array>
#include <cmath>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"
#include "worker/materials/land/broken_rock.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

// ---- Bedded rock

// Colours of beds from the lowest on; a rock takes them in this order, again and again.
struct StrataKind {
  std::array<uint32_t, 5> beds;
  uint32_t varnish;  // Colour of the streaks that water draws down a face.
};
constexpr std::array<StrataKind, 3> kRedKinds = {
    {{{0xa85c3c, 0xc2794c, 0x8f4a34, 0xd0a87c, 0xb56a42}, 0x4a3028},
     {{0xb98a5c, 0xc9a274, 0xa06a48, 0xd9c19a, 0x96583e}, 0x52382c},
     {{0x9c5238, 0xb06844, 0xc08858, 0x84442f, 0xcca27c}, 0x42282a}}};
constexpr std::array<StrataKind, 3> kGreyKinds = {
    {{{0xa8a294, 0x8f8a80, 0xb8b0a0, 0x7a766e, 0x9c9486}, 0x4c4a44},
     {{0xc2b89e, 0xaca288, 0xd0c8b2, 0x968c76, 0xb8ab90}, 0x5c5648},
     {{0x787672, 0x8a8680, 0x666460, 0x94908a, 0x6e6b67}, 0x3a3938}}};

// Beds across z in three sizes, each with its own tint and hardness; joints across them; streaks
// down steep faces.
class StrataRock final : public Carved<StrataRock> {
 public:
  StrataRock(Rng& rng, const std::array<StrataKind, 3>& kinds) {
    const StrataKind& kind = rng.Pick(kinds);
    const double value = rng.Uniform(-0.08, 0.08);
    for (size_t i = 0; i < kind.beds.size(); ++i) {
      beds_[i] =
          static_cast<float>(1 + value) * VaryColor(rng, SrgbColor(kind.beds[i]), 0.05, 0.03);
    }
    varnish_ = SrgbColor(kind.varnish);
    bed_m_ = Draw(rng, 5, 9);
    band_m_ = Draw(rng, 0.35, 0.8);
    streaks_ = Draw(rng, 0.12, 0.4);
    grain_m_ = Draw(rng, 0.0012, 0.0025);
    seed_ = DrawSeed(rng);
  }

  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 level = Level(p, w);
    const Float8 mottle = Fbm3(p, 0.9f, 6, w, seed_ + 2, 0.6f);
    Vec3x8 color = BedColor(level) * (1.0f + 0.3f * Bands(level, w) + 0.16f * mottle);
    Float8 grain = Splat(0);
    const Float8 fine = Fade(2.0f * grain_m_, w);
    if (Any(fine > 0)) {
      grain = 0.3f * fine * (UnitByte(noise::Cells3(p / grain_m_, seed_ + 4).id, 0) - 0.5f);
    }
    color *= (1.0f + grain) * (1.0f - 0.5f * Joints(p, w));
    // Water runs down what is steep.
    const Float8 steep = 1.0f - SmoothStep(0.15f, 0.55f, Abs(point.normal.z));
    const Float8 run = noise::Above(
        noise::Fbm3Filtered(Vec3x8(p.x, p.y, 0.05f * p.z), 2.7f, 3, w, seed_ + 6, 0.5f), 0.14f,
        0.22f);
    color = Mix(color, Vec3x8(varnish_), streaks_ * steep * run);
    return {.base_color = Albedo(color),
            .roughness = Saturate(0.88f + 0.08f * mottle),
            .specular = Splat(0.25f)};
  }

  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto& p = point.texture_m;
    return 0.012f * band_m_ * Bands(Level(p, w), w) - 0.005f * Joints(p, w) +
           0.0035f * Fbm3(p, 0.28f, 5, w, seed_ + 9, 0.55f) + kBroken * Broken().HeightAt(p, w);
  }
  float widest_relief_m() const override { return 0.5f * kLongestBlock_m; }

 private:
  static constexpr float kLongestBlock_m = 0.8f, kBroken = 0.8f;

  // Blocks and chips, smaller than those in the mesh of a boulder or in the ground's relief.
  BrokenRock Broken() const { return {kLongestBlock_m, 3, seed_ + 50}; }
  // Height in the pile of beds, metres: they undulate a little.
  template <typename Vec>
  RealOf<Vec> Level(const Vec& p, Float8 w) const {
    return p.z + 0.5f * Fbm3(p, 30.0f, 2, w, seed_) + 0.04f * Fbm3(p, 1.3f, 2, w, seed_ + 1);
  }
  Vec3x8 BedColor(Float8 level) const {
    // Uneven thickness; borders some centimetres wide.
    const Float8 at = level / bed_m_ + 0.7f * Gradient2(0.31f * level, Splat(0.5f), seed_ + 20);
    const Float8 bed = Floor(at), in = at - bed;
    const Float8 share = SmoothStep(0.94f, 1.0f, in);
    return Mix(ColorOf(bed), ColorOf(bed + 1.0f), share);
  }
  Vec3x8 ColorOf(Float8 bed) const {
    const Bits8 id = noise::Hash(noise::FloorInt(bed), seed_ + 21);
    const Float8 pick = 5.0f * noise::Unit(id);
    Vec3x8 color(beds_[0]);
    for (size_t i = 1; i < beds_.size(); ++i) {
      color = Select(pick >= static_cast<float>(i), Vec3x8(beds_[i]), color);
    }
    return color * (0.9f + 0.2f * UnitByte(id, 1));
  }
  // Thin layers; about [-1, 1].
  template <typename Real>
  Real Bands(const Real& level, Float8 w) const {
    Real sum = Splat(0);
    float wavelength = 2.2f * band_m_, strength = 0.8f;
    for (uint32_t i = 0; i < 5; ++i) {
      sum += strength * Fade(wavelength, w) *
             Gradient2(level / wavelength, Real(Splat(0.5f)), seed_ + 30 + i);
      wavelength *= 0.42f;
      strength *= 0.75f;
    }
    return 1.5f * sum;
  }
  // Cracks that stand upright, a metre or two apart; 1 within.
  template <typename Vec>
  RealOf<Vec> Joints(const Vec& p, Float8 w) const {
    constexpr float kWave = 1.9f, kWidth = 0.03f;
    const Float8 fade = Fade(kWave, w);
    if (!Any(fade > 0)) return Splat(0);
    const Vec q = VecOf(p.x, p.y, 0.22f * p.z);
    const auto n =
        Gradient3(q / kWave, seed_ + 40) + 0.2f * Gradient3(q / (0.3f * kWave), seed_ + 41);
    const auto open = SmoothStep(0.0f, 0.3f, Gradient3(p / 2.7f, seed_ + 42));
    const Float8 wide = kWidth + 2.0f * w / kWave;
    return fade * open * (kWidth / wide) * (1.0f - SmoothStep(0.2f * wide, wide, Abs(n)));
  }

  std::array<Vec3f, 5> beds_;
  Vec3f varnish_;
  float bed_m_, band_m_, streaks_, grain_m_;
};

// ---- Sand

// Dry sand that wind sorted: ripples across x, which fork and die out, coarse dark grains in their
// troughs.
class DesertSand final : public Carved<DesertSand> {
 public:
  explicit DesertSand(Rng& rng) {
    sand_ = PickColor(rng, {0xd2a06c, 0xdcbd90, 0xc88a58, 0xe0cba6, 0xcba678}, 0.07, 0.03);
    dark_ = sand_ * Draw(rng, 0.62, 0.78);
    grain_m_ = Draw(rng, 0.0007, 0.0012);
    ripple_m_ = Draw(rng, 0.09, 0.15);
    depth_m_ = ripple_m_ * Draw(rng, 0.035, 0.055);
    seed_ = DrawSeed(rng);
  }

  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 ripple = RippleShare(point.normal) * Ripples(p, w);
    const Float8 broad = Fbm3(p, 2.6f, 5, w, seed_ + 4, 0.55f);
    Float8 tone = Splat(0);
    const Float8 fade = Fade(2.0f * grain_m_, w);
    if (Any(fade > 0)) {
      tone = 0.7f * fade * (UnitByte(noise::Cells3(p / grain_m_, seed_).id, 0) - 0.5f);
    }
    const Float8 trough = Saturate(0.35f - 0.5f * ripple + 0.35f * broad);
    return {.base_color = Albedo(Mix(Vec3x8(sand_), Vec3x8(dark_), trough) * (1.0f + tone) *
                                 (1.0f + 0.1f * broad)),
            .roughness = Splat(0.95f),
            .specular = Splat(0.25f)};
  }

  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto& p = point.texture_m;
    return depth_m_ * RippleShare(point.normal) * Ripples(p, w) +
           2.5e-3f * Fbm3(p, 0.3f, 4, w, seed_ + 6, 0.5f);
  }

 private:
  // The wind ripples what it can push; on slopes near the angle of repose sand slides.
  static Float8 RippleShare(const Vec3x8& normal) {
    return SmoothStep(0.82f, Splat(0.94f), Abs(normal.z));
  }
  // About [-1, 1]; the lee is twice as steep as the side before the wind.
  template <typename Vec>
  RealOf<Vec> Ripples(const Vec& p, Float8 w) const {
    const Float8 fade = Fade(ripple_m_, w);
    if (!Any(fade > 0)) return Splat(0);
    const auto wander =
        1.3f * Gradient3(p / (7.0f * ripple_m_), seed_ + 8) +
        0.3f * Gradient3(VecOf(p.x, 0.4f * p.y, p.z) / (1.7f * ripple_m_), seed_ + 9);
    const auto strength = SmoothStep(-0.75f, 0.1f, Gradient3(p / (22.0f * ripple_m_), seed_ + 10));
    const auto x = p.x / ripple_m_ + wander;
    const auto wave = noise::CosTurn(x), lean = noise::CosTurn(2.0f * x + 0.25f);
    return fade * strength * (0.8f * wave + 0.16f * lean);
  }

  Vec3f sand_, dark_;
  float grain_m_, ripple_m_, depth_m_;
};

// ---- Snow

// Wind packed it into soft waves and pits; grains shade it finely. It never glitters: a sparkle is
// in one eye only.
class Snow final : public Carved<Snow> {
 public:
  explicit Snow(Rng& rng) {
    const float white = Draw(rng, 0.82, 0.88);
    snow_ = white * Vec3f(0.985f, 0.995f, 1.0f);
    wave_m_ = Draw(rng, 0.5, 1.1);
    const float turn = Draw(rng, 0, 6.2831853);
    across_ = Vec3f(std::cos(turn), std::sin(turn), 0.1f);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 broad = Fbm3(p, 3.1f, 5, w, seed_ + 2, 0.6f);
    const Float8 grain = Fbm3(p, 0.006f, 3, w, seed_ + 3, 0.7f);
    SurfaceSample8 out;
    // Old crust is a little darker than what blew on it.
    out.base_color = Albedo(snow_ * (1.0f + 0.05f * broad + 0.07f * grain));
    out.roughness = Splat(0.75f);
    out.specular = Splat(0.2f);
    out.subsurface = Splat(0.5f);
    return out;
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto& p = point.texture_m;
    return 0.009f * wave_m_ * Drifts(p, w) + 2e-3f * Fbm3(p, 0.16f, 5, w, seed_ + 6, 0.6f) +
           6e-4f * Fbm3(p, 0.008f, 2, w, seed_ + 7, 0.6f);
  }

 private:
  // Long in the wind, with undercut ends.
  template <typename Vec>
  RealOf<Vec> Drifts(const Vec& p, Float8 w) const {
    const auto along = Along(across_, p);
    const Vec q = p + Vec3f(-0.65f * across_) * along;
    RealOf<Vec> sum = Splat(0);
    float wavelength = wave_m_, strength = 1;
    for (uint32_t i = 0; i < 3; ++i) {
      const Float8 fade = Fade(wavelength, w);
      if (!Any(fade > 0)) break;
      const auto n = Gradient3(q / wavelength, seed_ + 10 + i);
      sum += strength * fade * (n - 0.35f * Abs(n));
      wavelength *= 0.45f;
      strength *= 0.5f;
    }
    return sum;
  }

  Vec3f snow_, across_;
  float wave_m_;
};

// ---- Caves

// Limestone that water dissolved and covered with sinter: scalloped, banded down its faces, wet in
// places.
class CaveRock final : public Carved<CaveRock> {
 public:
  explicit CaveRock(Rng& rng) {
    static constexpr std::array<std::array<uint32_t, 3>, 4> kKinds = {
        {{0xb8a68a, 0x9a8468, 0xd6c8ac},
         {0xa89c8c, 0x857a6c, 0xcabfae},
         {0xb59472, 0x8f6c4c, 0xd9bd94},
         {0x9c9a92, 0x78756c, 0xc4c0b2}}};
    const auto& kind = rng.Pick(kKinds);
    stone_ = VaryColor(rng, SrgbColor(kind[0]), 0.08, 0.03);
    stain_ = VaryColor(rng, SrgbColor(kind[1]), 0.08, 0.04);
    sinter_ = VaryColor(rng, SrgbColor(kind[2]), 0.06, 0.03);
    wet_ = Draw(rng, 0.2, 0.7);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 mottle = Fbm3(p, 1.3f, 7, w, seed_, 0.62f);
    const Vec3x8 down(p.x, p.y, 0.12f * p.z);
    const Float8 flow = Fbm3(down, 0.8f, 6, w, seed_ + 2, 0.62f);
    const Float8 covered =
        noise::Above(noise::Fbm3Filtered(down, 1.7f, 5, w, seed_ + 3, 0.6f), 0.1f, 0.2f);
    Vec3x8 color = Mix(Vec3x8(stain_), Vec3x8(stone_), Saturate(0.55f + 0.8f * mottle));
    color = Mix(color, sinter_ * (1.0f + 0.35f * flow), 0.75f * covered);
    const Float8 wet =
        wet_ * noise::Above(noise::Fbm3Filtered(down, 1.1f, 4, w, seed_ + 5, 0.6f), 0.16f, 0.15f);
    return {.base_color = Albedo(color * (1.0f - 0.38f * wet) * (1.0f + 0.15f * flow)),
            .roughness = Saturate(0.8f - 0.5f * wet + 0.1f * mottle),
            .specular = Splat(0.4f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto& p = point.texture_m;
    return 0.25f * Hollows(p, w) +
           0.0025f * Fbm3(VecOf(p.x, p.y, 0.25f * p.z), 0.3f, 5, w, seed_ + 9, 0.6f);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Hollows(const Vec& p, Float8 w) const {
    RealOf<Vec> sum = Splat(0);
    float wavelength = 0.55f;
    for (uint32_t i = 0; i < 4; ++i) {
      const Float8 fade = Fade(wavelength, w);
      if (!Any(fade > 0)) break;
      sum +=
          fade * 0.1f * wavelength * (0.4f - 1.6f * Abs(Gradient3(p / wavelength, seed_ + 20 + i)));
      wavelength *= 0.45f;
    }
    return sum;
  }

  Vec3f stone_, stain_, sinter_;
  float wet_;
};

// ---- Skins of desert plants

struct SkinKind {
  std::array<uint32_t, 3> skins;
  uint32_t spot;         // Spines and their cushions; margins of leaves.
  bool margins = false;  // Else spots in rows.
};
constexpr SkinKind kCactusKind = {{0x66784a, 0x5c7052, 0x748252}, 0xc9b98c, false};
constexpr SkinKind kAgaveKind = {{0x7d9080, 0x6f8468, 0x8fa094}, 0x8a7448, true};

// Waxy, scarred near the ground. uv of cacti: x is 0 on a rib's crest and 1 in the groove, y counts
// the cushions of spines along it; of agaves: x is 0 in a leaf's middle and 1 on its margin.
class SucculentSkin final : public Carved<SucculentSkin> {
 public:
  SucculentSkin(Rng& rng, const SkinKind& kind) : margins_(kind.margins) {
    skin_ = VaryColor(rng, SrgbColor(rng.Pick(kind.skins)), 0.1, 0.04);
    spot_ = VaryColor(rng, SrgbColor(kind.spot), 0.1, 0.03);
    scar_ = SrgbColor(0x8f7d5c);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 n = Fbm3(p, 0.12f, 6, w, seed_, 0.6f);
    const Float8 scars =
        noise::Above(noise::Fbm3Filtered(p, 0.2f, 5, w, seed_ + 3, 0.6f), 0.36f, 0.1f);
    // Grooves are greener, crests worn.
    const Float8 own = Fade(1.0f, point.footprint_uv);
    const Float8 across = 0.5f + own * (Saturate(point.u) - 0.5f);
    Vec3x8 color = skin_ * ((1.12f - 0.4f * across) * (1.0f + 0.25f * n));
    color = Mix(color, Vec3x8(scar_), 0.6f * scars);
    return {.base_color = Albedo(Mix(color, Vec3x8(spot_), 0.8f * Spots(point))),
            .roughness = Saturate(0.5f + 0.2f * n + 0.2f * scars),
            .specular = Splat(0.35f),
            .subsurface = Splat(0.3f)};
  }
  auto HeightOf(const auto& point) const {
    return 8e-4f * Fbm3(point.texture_m, 0.03f, 4, point.footprint_m, seed_ + 6, 0.6f);
  }

 private:
  Float8 Spots(const SurfacePoint8& point) const {
    const Float8 own = Fade(1.0f, point.footprint_uv);
    // Seen from far, what the margins are of a leaf.
    if (margins_) return 0.085f + own * (SmoothStep(0.86f, 0.97f, point.u) - 0.085f);
    const Float8 across = point.u * 2.6f, along = 2.0f * (noise::Fract(point.v) - 0.5f);
    const Float8 spot = 1.0f - SmoothStep(0.25f, 0.75f, across * across + along * along);
    const Float8 far = 0.16f * (1.0f - (0.5f + own * (Saturate(point.u) - 0.5f)));
    return far + own * (spot - far);
  }

  bool margins_;
  Vec3f skin_, spot_, scar_;
};

}  // namespace

void AddLandMaterials(MaterialList& list) {
  const MaterialTags own = {.diffuse = true, .any_object = false};
  list.push_back(Entry<SucculentSkin>("AgaveSkin", "land", own, kAgaveKind));
  list.push_back(Entry<SucculentSkin>("CactusSkin", "land", own, kCactusKind));
  list.push_back(Entry<CaveRock>("CaveRock", "land", own));
  list.push_back(Entry<DesertSand>("DesertSand", "land", own));
  list.push_back(Entry<StrataRock>("GreyStrata", "land", own, kGreyKinds));
  list.push_back(Entry<StrataRock>("RedStrata", "land", own, kRedKinds));
  list.push_back(Entry<Snow>("Snow", "land", own));
}

}  // namespace parallax
