// Family `ceramic`: glazed and bare pottery, tiles with grout.
#include <array>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

Vec3f DrawGlaze(Rng& rng) {
  static constexpr std::array<uint32_t, 16> kGlazes = {
      0xe9e7e2, 0xe3dfd3, 0xd9d4c6, 0xcfd6d6, 0x9fb9bd, 0x5f8a94, 0x2f5a78, 0x23395c,
      0x7f9a7a, 0x4a6b52, 0xb7a06a, 0xc77b4a, 0x8f3f34, 0x5a3a36, 0x3a3d42, 0xd9a9a0};
  return VaryColor(rng, SrgbColor(rng.Pick(kGlazes)), 0.1, 0.05);
}

// Glass over clay: it runs thick and thin, breaks to another tone where it is thin, and holds
// pinholes.
class GlazedCeramic final : public Carved<GlazedCeramic> {
 public:
  explicit GlazedCeramic(Rng& rng) {
    thick_ = DrawGlaze(rng);
    const Vec3f other = DrawGlaze(rng);
    thin_ = Mix(thick_, other, Draw(rng, 0.1, 0.6));
    flow_m_ = Draw(rng, 0.03, 0.10);
    roughness_ = rng.Bernoulli(0.75) ? Draw(rng, 0.06, 0.15) : Draw(rng, 0.3, 0.5);
    crackle_ = rng.Bernoulli(0.25) ? Draw(rng, 0.2, 0.5) : 0.0f;
    crackle_m_ = Draw(rng, 0.006, 0.016);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 flow = Fbm3(Vec3x8(p.x, p.y, 0.5f * p.z), flow_m_, 4, w, seed_, 0.55f);
    const Float8 speck = Fade(2e-3f, w) * SmoothStep(0.5f, 0.75f, Gradient3(p * 420.0f, seed_ + 2));
    SurfaceSample8 out;
    Vec3x8 color = Mix(thick_, thin_, SmoothStep(-0.55f, 0.75f, flow)) * (1.0f + 0.06f * flow);
    color *= 1.0f - 0.35f * speck;
    if (crackle_ > 0) color *= 1.0f - crackle_ * Crackle(p, w);
    out.base_color = Albedo(color);
    out.roughness = Saturate(roughness_ * (1.0f + 0.2f * flow));
    out.subsurface = Splat(0.25f);
    return out;
  }
  auto HeightOf(const auto& point) const {
    return 5e-5f * Fbm3(point.texture_m, 0.4f * flow_m_, 2, point.footprint_m, seed_ + 5, 0.3f);
  }

 private:
  Float8 Crackle(const Vec3x8& p, Float8 w) const {
    const Float8 fade = Fade(crackle_m_, w);
    if (!Any(fade > 0)) return Splat(0.08f);
    const noise::Cell8 cell = noise::Cells3(p / crackle_m_, seed_ + 9);
    const Float8 wide = 0.05f + w / crackle_m_;
    const Float8 line = (0.05f / wide) * (1.0f - SmoothStep(0.0f, wide, cell.f2 - cell.f1));
    return 0.08f + fade * (line - 0.08f);
  }

  Vec3f thick_, thin_;
  float flow_m_, roughness_, crackle_, crackle_m_;
};

// Iron specks of two sizes under a pale glaze.
class SpeckledCeramic final : public Carved<SpeckledCeramic> {
 public:
  explicit SpeckledCeramic(Rng& rng) {
    ground_ = DrawGlaze(rng);
    const bool pale = Luminance(ground_) > 0.2f;
    speck_ = pale ? VaryColor(rng, SrgbColor(0x3f332b), 0.3, 0.08)
                  : VaryColor(rng, SrgbColor(0xd8d0c2), 0.1, 0.05);
    size_m_ = Draw(rng, 0.003, 0.007);
    share_ = Draw(rng, 0.25, 0.7);
    roughness_ = rng.Bernoulli(0.5) ? Draw(rng, 0.1, 0.2) : Draw(rng, 0.4, 0.6);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 specks = Saturate(0.9f * Specks(p, size_m_, share_, seed_, w) +
                                   0.7f * Specks(p, 0.42f * size_m_, share_, seed_ + 1, w));
    const Float8 tone = Fbm3(p, 0.06f, 3, w, seed_ + 2);
    return {.base_color = Albedo(Mix(ground_ * (1.0f + 0.06f * tone), speck_, specks)),
            .roughness = Saturate(roughness_ * (1.0f + 0.4f * specks))};
  }
  auto HeightOf(const auto& point) const {
    return 3e-5f * Fbm3(point.texture_m, 0.012f, 2, point.footprint_m, seed_ + 5);
  }

 private:
  static Float8 Specks(const Vec3x8& p, float size_m, float share, uint32_t seed, Float8 w) {
    const float mean = 0.10f * share;
    const Float8 fade = Fade(size_m, w);
    if (!Any(fade > 0)) return Splat(mean);
    const noise::Cell8 cell = noise::Cells3(p / size_m, seed);
    const Float8 radius = 0.14f + 0.3f * UnitByte(Hash(1, cell.id), 1);
    const Float8 soft = Max(0.3f * radius, w / size_m);
    const Float8 speck = 1.0f - SmoothStep(radius - 0.5f * soft, radius + 0.5f * soft, cell.f1);
    return mean + fade * ((noise::Unit(cell.id) < share ? speck : Splat(0)) - mean);
  }

  Vec3f ground_, speck_;
  float size_m_, share_, roughness_;
};

// Unglazed red clay with the marks of the wheel around z and a bloom of lime.
class Terracotta final : public Carved<Terracotta> {
 public:
  explicit Terracotta(Rng& rng) {
    clay_ = PickColor(rng, {0xb5694a, 0xa9583c, 0xc58a66, 0xd0b394, 0x8a5a48}, 0.12, 0.04);
    bloom_ = Draw(rng, 0.05, 0.4);
    turn_m_ = Draw(rng, 0.003, 0.008);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 n = Fbm3(p, 0.08f, 5, w, seed_, 0.6f);
    const Float8 lime =
        bloom_ * noise::Above(noise::Fbm3Filtered(p, 0.1f, 5, w, seed_ + 3, 0.6f), 0.35f, 0.35f);
    return {.base_color = Albedo(
                Mix(clay_ * (1.0f + 0.13f * n + 0.05f * Turns(p, w)), SrgbColor(0xd9cfc2), lime)),
            .roughness = Splat(0.85f),
            .specular = Splat(0.3f)};
  }
  auto HeightOf(const auto& point) const {
    return 5e-5f * Turns(point.texture_m, point.footprint_m) +
           5e-5f * Fbm3(point.texture_m, 0.003f, 2, point.footprint_m, seed_ + 6);
  }

 private:
  template <typename Vec>
  RealOf<Vec> Turns(const Vec& p, Float8 w) const {
    return Fade(turn_m_, w) * Gradient3(p.x * 6.0f, p.y * 6.0f, p.z / turn_m_, seed_ + 8);
  }

  Vec3f clay_;
  float bloom_, turn_m_;
};

struct TileStyle {
  double width_low_m, width_high_m;
  double aspect = 1;  // Length over width.
  bool running_bond = false;
  double grout_mm = 3;
  int palette = 1;  // Glazes that alternate at random.
  double tile_variation = 0.1;
};

// Pressed tiles: rounded edges, a pillow each, own tint and own tilt; grout between.
class CeramicTiles final : public Carved<CeramicTiles> {
 public:
  CeramicTiles(Rng& rng, const TileStyle& style) : style_(style) {
    width_m_ = Draw(rng, style.width_low_m, style.width_high_m);
    length_m_ = width_m_ * Float(style.aspect);
    gap_m_ = Float(style.grout_mm) * 1e-3f * Draw(rng, 0.7, 1.4);
    bevel_m_ = Draw(rng, 0.0015, 0.004);
    mean_.setZero();
    const Vec3f first = DrawGlaze(rng);
    for (int i = 0; i < style.palette; ++i) {
      const auto k = static_cast<size_t>(i);
      glazes_[k] = first;
      if (i > 0) {
        const Vec3f other = DrawGlaze(rng);
        glazes_[k] = Mix(first, other, Draw(rng, 0.3, 0.9));
      }
      mean_ += glazes_[k] / static_cast<float>(style.palette);
    }
    chequered_ = style.palette == 2;
    grout_ = VaryColor(rng, SrgbColor(rng.Bernoulli(0.6) ? 0xc6c2ba : 0x6a6865), 0.15, 0.03);
    variation_ = Float(style.tile_variation) * Draw(rng, 0.5, 1.5);
    roughness_ = rng.Bernoulli(0.7) ? Draw(rng, 0.06, 0.2) : Draw(rng, 0.35, 0.5);
    cloudy_ = Draw(rng, 0.02, 0.12);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const auto tile = At(OnPlane(point));

    const float mean_cover = 1.0f - gap_m_ / width_m_ - gap_m_ / length_m_;
    const Float8 fade = Fade(width_m_, w);
    const Float8 solid = noise::Lerp(
        mean_cover, 1.0f - LineShare(tile.edge_m, 0.5f * gap_m_, 0.0006f, 1.2f * w), fade);
    const Float8 cloud =
        Fbm3(point.texture_m + Vec3x8::All(4.0f * UnitByte(tile.id, 2)), 0.05f, 4, w, seed_ + 3);
    const Float8 own = 1.0f + variation_ * fade * (UnitByte(tile.id, 0) - 0.5f);
    const Vec3x8 glaze = Mix(mean_, tile.glaze, fade) * (own * (1.0f + cloudy_ * cloud));
    const Float8 dirt = Fbm3(point.texture_m, 0.03f, 3, w, seed_ + 6);
    return {.base_color = Albedo(Mix(grout_ * (1.0f + 0.2f * dirt), glaze, solid)),
            .roughness = Saturate(noise::Lerp(0.9f, roughness_ * (1.0f + 0.2f * cloud), solid))};
  }
  template <typename Point>
  typename Point::Real HeightOf(const Point& point) const {
    const Float8 w = point.footprint_m;
    const Float8 fade = Fade(width_m_, w);
    if (!Any(fade > 0)) return Splat(0);
    const auto tile = At(OnPlane(point));
    const auto rise =
        1.0f - LineShare(tile.edge_m, 0.5f * gap_m_ + 0.3f * bevel_m_, bevel_m_, 2.0f * w);
    // Neighbours are tilted otherwise: the tilt is let in from the joint's middle.
    const auto own = SmoothStep(0.0f, 0.5f * gap_m_ + bevel_m_, tile.edge_m);
    const auto inside = SmoothStep(0.0f, 0.3f * width_m_, tile.edge_m);
    // Each tile is set a little askew; the glaze is a little wavy.
    const auto tilt = 3e-3f * ((UnitByte(tile.id, 1) - 0.5f) * tile.u_m +
                               (UnitByte(tile.id, 3) - 0.5f) * tile.v_m);
    const auto wave = 2e-5f * Fbm3(point.texture_m, 0.02f, 2, w, seed_ + 8);
    const auto sand = 6e-5f * Fbm3(point.texture_m, 0.002f, 2, w, seed_ + 9);
    return fade * (rise * (1.2e-3f + 1e-4f * inside + own * tilt + wave) + (1.0f - rise) * sand);
  }

 private:
  template <typename Real>
  struct Tile {
    Real u_m, v_m;  // From its centre.
    Real edge_m;    // To the middle of the nearest joint.
    Bits8 id;
    Vec3x8 glaze;
  };

  template <typename Real>
  Tile<Real> At(const PlaneOf8<Real>& plane) const {
    const Real row = plane.v / width_m_;
    const Int8 j = noise::FloorInt(row);
    const Real column =
        plane.u / length_m_ + (style_.running_bond ? 0.5f * ToFloat(j & 1) : Splat(0));
    const Int8 i = noise::FloorInt(column);
    Tile<Real> tile;
    tile.u_m = (column - ToFloat(i) - 0.5f) * length_m_;
    tile.v_m = (row - ToFloat(j) - 0.5f) * width_m_;
    tile.edge_m = Min(0.5f * length_m_ - Abs(tile.u_m), 0.5f * width_m_ - Abs(tile.v_m));
    tile.id = Hash(i, j, seed_);
    const Int8 glaze =
        chequered_ ? (i + j) & 1
                   : ToInt(noise::Unit(Hash(i, j, seed_ + 1)) * static_cast<float>(style_.palette));
    for (int lane = 0; lane < kLanes; ++lane) {
      tile.glaze.Set(lane, glazes_[static_cast<size_t>(glaze[lane])]);
    }
    return tile;
  }

  TileStyle style_;
  std::array<Vec3f, 6> glazes_;
  Vec3f mean_, grout_;
  float width_m_, length_m_, gap_m_, bevel_m_, variation_, roughness_, cloudy_;
  bool chequered_;
};

}  // namespace

void AddCeramicMaterials(MaterialList& list) {
  const MaterialTags tiles = {.walls = true, .floor = true, .any_object = false};
  list.push_back(Entry<GlazedCeramic>("GlazedCeramic", "ceramic", {}));
  list.push_back(Entry<SpeckledCeramic>("SpeckledCeramic", "ceramic", {}));
  list.push_back(Entry<Terracotta>("Terracotta", "ceramic", {.diffuse = true}));
  list.push_back(Entry<CeramicTiles>("CeramicTiles", "ceramic", tiles,
                                     TileStyle{.width_low_m = 0.15, .width_high_m = 0.4}));
  list.push_back(Entry<CeramicTiles>(
      "CheckerTiles", "ceramic", tiles,
      TileStyle{.width_low_m = 0.12, .width_high_m = 0.33, .grout_mm = 2, .palette = 2}));
  list.push_back(Entry<CeramicTiles>("MosaicTiles", "ceramic", {.walls = true, .floor = true},
                                     TileStyle{.width_low_m = 0.012,
                                               .width_high_m = 0.03,
                                               .grout_mm = 1.5,
                                               .palette = 5,
                                               .tile_variation = 0.3}));
  list.push_back(Entry<CeramicTiles>("SubwayTiles", "ceramic", {.walls = true, .any_object = false},
                                     TileStyle{.width_low_m = 0.065,
                                               .width_high_m = 0.1,
                                               .aspect = 2.0,
                                               .running_bond = true,
                                               .grout_mm = 2.5}));
}

}  // namespace parallax
