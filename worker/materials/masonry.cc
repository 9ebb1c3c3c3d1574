// Families `brick`, `concrete` and `terrazzo`.
#include <array>

#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

// Running bond; each brick burnt its own way, edges worn, mortar raked.
class Brick final : public Carved<Brick> {
 public:
  Brick(Rng& rng, bool painted) : painted_(painted) {
    static constexpr std::array<uint32_t, 6> kClays = {0x9c5442, 0x8a4638, 0xb5745a,
                                                       0xc79b72, 0x6f4a42, 0x8f8478};
    clay_ = VaryColor(rng, SrgbColor(rng.Pick(kClays)), 0.1, 0.04);
    burnt_ = clay_.cwiseProduct(Vec3f(0.5f, 0.45f, 0.48f));
    mortar_ = VaryColor(rng, SrgbColor(rng.Bernoulli(0.7) ? 0xb9b2a6 : 0x75716c), 0.1, 0.03);
    paint_ = VaryColor(rng, SrgbColor(rng.Bernoulli(0.6) ? 0xe6e2da : 0x9aa6a6), 0.12, 0.04);
    length_m_ = Draw(rng, 0.19, 0.25);
    height_m_ = Draw(rng, 0.055, 0.075);
    gap_m_ = Draw(rng, 0.008, 0.012);
    depth_m_ = Draw(rng, 0.002, 0.005);
    ragged_m_ = Draw(rng, 0.001, 0.0035);
    spread_ = Draw(rng, 0.25, 0.7);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const PlanePoint8 plane = OnPlane(point);
    const auto brick = At(plane, w);
    const Float8 fade = Fade(height_m_, w);
    const float mean_solid = 1.0f - gap_m_ / height_m_ - gap_m_ / length_m_;
    const Float8 solid = noise::Lerp(
        mean_solid, 1.0f - LineShare(brick.edge_m, 0.5f * gap_m_, 0.0015f, 1.2f * w), fade);
    const Float8 n = Fbm3(point.texture_m, 0.04f, 5, w, seed_ + 3, 0.65f);
    SurfaceSample8 out{.roughness = Splat(0.9f), .specular = Splat(0.3f)};
    if (painted_) {
      const Float8 dirt = Fbm3(point.texture_m, 0.3f, 4, w, seed_ + 5);
      out.base_color =
          Albedo(paint_ * ((0.86f + 0.14f * solid) * (1.0f + 0.05f * n + 0.05f * dirt)));
      out.roughness = Splat(0.7f);
      return out;
    }
    const Float8 burnt =
        Saturate(0.35f + fade * spread_ * (2.0f * UnitByte(brick.id, 0) - 1.0f) + 0.25f * n);
    const Float8 tone = 1.0f + 0.2f * fade * (UnitByte(brick.id, 1) - 0.5f);
    out.base_color = Albedo(Mix(mortar_ * (1.0f + 0.2f * n),
                                Mix(clay_, burnt_, burnt) * (tone * (1.0f + 0.18f * n)), solid));
    return out;
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto brick = At(OnPlane(point), w);
    const Float8 fade = Fade(height_m_, w);
    const float soft = painted_ ? 0.006f : 0.004f;
    const auto rise = fade * (1.0f - LineShare(brick.edge_m, 0.5f * gap_m_, soft, 2.0f * w));
    const auto pits = Fbm3(point.texture_m, 0.012f, 4, w, seed_ + 7, 0.6f);
    return depth_m_ * rise + (painted_ ? 1.5e-4f : 4e-4f) * pits;
  }

 private:
  template <typename Real>
  struct Course {
    Real edge_m;  // To the middle of the nearest joint.
    Bits8 id;
  };
  template <typename Real>
  Course<Real> At(const PlaneOf8<Real>& plane, Float8 w) const {
    // Edges are not straight: the query is shaken before it is laid on the grid.
    const Float8 shake = ragged_m_ * Fade(0.02f, w);
    const Real a = plane.u * 45.0f, b = plane.v * 45.0f;
    const Real u = plane.u + shake * Gradient2(a, b, seed_ + 1);
    const Real v = plane.v + shake * Gradient2(a, b, seed_ + 2);
    const Real row = v / height_m_;
    const Int8 j = noise::FloorInt(row);
    const Real column = u / length_m_ + 0.5f * ToFloat(j & 1);
    const Int8 i = noise::FloorInt(column);
    const Real x = (0.5f - Abs(column - ToFloat(i) - 0.5f)) * length_m_;
    const Real y = (0.5f - Abs(row - ToFloat(j) - 0.5f)) * height_m_;
    return {Min(x, y), Hash(i, j, seed_)};
  }

  bool painted_;
  Vec3f clay_, burnt_, mortar_, paint_;
  float length_m_, height_m_, gap_m_, depth_m_, ragged_m_, spread_;
};

// Cast against boards or steel: clouds, air holes, stains.
class Concrete final : public Carved<Concrete> {
 public:
  explicit Concrete(Rng& rng) {
    grey_ = VaryColor(rng, SrgbColor(rng.Bernoulli(0.7) ? 0xa5a29c : 0x7f7d7a), 0.15, 0.02);
    cloud_ = Draw(rng, 0.1, 0.24);
    hole_m_ = Draw(rng, 0.012, 0.03);
    holes_ = Draw(rng, 0.2, 0.6);
    polished_ = rng.Bernoulli(0.3);
    roughness_ = polished_ ? Draw(rng, 0.25, 0.4) : Draw(rng, 0.75, 0.92);
    board_m_ = rng.Bernoulli(0.35) ? Draw(rng, 0.1, 0.2) : 0.0f;
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 cloud = Fbm3(p, 0.45f, 7, w, seed_, 0.62f);
    const Float8 grain = Fbm3(p, 0.004f, 2, w, seed_ + 4);
    const Float8 hole = Holes(OnPlane(point), w);
    return {.base_color =
                Albedo(grey_ * ((1.0f + cloud_ * cloud + 0.07f * grain) * (1.0f - 0.6f * hole))),
            .roughness = Saturate(roughness_ * (1.0f + 0.1f * cloud)),
            .specular = Splat(0.4f)};
  }
  auto HeightOf(const auto& point) const {
    const Float8 w = point.footprint_m;
    const auto plane = OnPlane(point);
    auto height = -1.2e-3f * Holes(plane, w);
    if (!polished_) height += 1.5e-4f * Fbm3(point.texture_m, 0.01f, 3, w, seed_ + 6);
    if (board_m_ > 0) {
      // Fins between boards, and the grain that they left.
      const auto x = Abs(noise::Fract(plane.v / board_m_) - 0.5f) * board_m_;
      height +=
          4e-4f * Fade(board_m_, w) * LineShare(0.5f * board_m_ - x, 0.0015f, 0.003f, 2.0f * w);
      height += 1e-4f * Fade(0.004f, w) * Gradient2(plane.u * 6.0f, plane.v * 280.0f, seed_ + 9);
    }
    return height;
  }

 private:
  template <typename Real>
  Real Holes(const PlaneOf8<Real>& plane, Float8 w) const {
    const float mean = 0.06f * holes_;
    const Float8 fade = Fade(0.6f * hole_m_, w);
    if (!Any(fade > 0)) return Splat(mean);
    const auto cell = noise::Cells2(plane.u / hole_m_, plane.v / hole_m_, seed_ + 2);
    const Float8 size = UnitByte(Hash(3, cell.id), 1);
    const Float8 radius = 0.05f + 0.2f * size * size;
    const Real deep = (1.0f - SmoothStep(0.6f * radius, radius + w / hole_m_, cell.f1)) *
                      SmoothStep(0.0f, 0.1f, cell.f2 - cell.f1);
    const Real hole = Select(noise::Unit(cell.id) < holes_, deep, Splat(0));
    return mean + fade * (hole - mean);
  }

  Vec3f grey_;
  float cloud_, hole_m_, holes_, roughness_, board_m_;
  bool polished_;
};

// Chips of marble in cement, ground flat: two sizes of flat-sided grains with cement between.
class Terrazzo final : public Carved<Terrazzo> {
 public:
  explicit Terrazzo(Rng& rng) {
    static constexpr std::array<uint32_t, 6> kCements = {0xdad5cc, 0xc9c4bb, 0x8f9190,
                                                         0x4a4c4f, 0xd9c4b4, 0xb5c2bb};
    static constexpr std::array<uint32_t, 10> kChips = {0xefeae0, 0x2c2d2f, 0x8a6a4f, 0xb7806a,
                                                        0x6f7f78, 0xc9a86a, 0x9aa3a8, 0x5b3b34,
                                                        0xd0b8a0, 0x45607a};
    cement_ = VaryColor(rng, SrgbColor(rng.Pick(kCements)), 0.08, 0.03);
    mean_chip_.setZero();
    for (Vec3f& chip : chips_) {
      chip = VaryColor(rng, SrgbColor(rng.Pick(kChips)), 0.1, 0.04);
      mean_chip_ += chip / static_cast<float>(chips_.size());
    }
    chip_m_ = Draw(rng, 0.010, 0.028);
    share_ = Draw(rng, 0.45, 0.85);
    roughness_ = Draw(rng, 0.08, 0.25);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Vec3x8& p = point.texture_m;
    const Float8 tone = Fbm3(p, 0.03f, 4, w, seed_ + 4);
    Vec3x8 color = cement_ * (1.0f + 0.08f * tone);
    color = Chips(p, 0.4f * chip_m_, 0.6f * share_, seed_ + 1, w, color);
    color = Chips(p, chip_m_, share_, seed_, w, color);
    return {.base_color = Albedo(color), .roughness = Saturate(roughness_ * (1.0f + 0.15f * tone))};
  }
  auto HeightOf(const auto& point) const {
    return 1.5e-5f * Fbm3(point.texture_m, 0.02f, 3, point.footprint_m, seed_ + 6);
  }

 private:
  Vec3x8 Chips(const Vec3x8& p, float size_m, float share, uint32_t seed, Float8 w,
               const Vec3x8& under) const {
    const Vec3x8 mean = Mix(under, mean_chip_, Splat(0.3f * share));
    const Float8 fade = Fade(1.2f * size_m, w);
    if (!Any(fade > 0)) return mean;
    const noise::Cell8 cell = noise::Cells3(p / size_m, seed, 0.9f);
    const Bits8 draw = Hash(5, cell.id);
    const Float8 gap = 0.08f + 0.3f * UnitByte(draw, 0);
    const Float8 soft = 0.03f + w / size_m;
    const Float8 inside = SmoothStep(gap - soft, gap + soft, cell.f2 - cell.f1) *
                          (1.0f - SmoothStep(0.5f, 0.62f, cell.f1));
    const float* chips = chips_[0].data();
    const Int8 at = (Int8)((draw >> 8) % static_cast<uint32_t>(chips_.size())) * 3;
    const Vec3x8 chip(Gather(chips, at), Gather(chips + 1, at), Gather(chips + 2, at));
    const Vec3x8 here = Mix(under, chip * (0.85f + 0.3f * UnitByte(draw, 2)), inside);
    return Mix(mean, Select(noise::Unit(cell.id) < share, here, under), fade);
  }

  std::array<Vec3f, 5> chips_;
  Vec3f cement_, mean_chip_;
  float chip_m_, share_, roughness_;
};

}  // namespace

void AddMasonryMaterials(MaterialList& list) {
  const MaterialTags wall = {.diffuse = true, .walls = true, .any_object = false};
  list.push_back(Entry<Brick>("Brick", "brick", wall, false));
  list.push_back(Entry<Brick>("PaintedBrick", "brick", wall, true));
  list.push_back(Entry<Concrete>("Concrete", "concrete",
                                 {.diffuse = true, .walls = true, .floor = true, .ceiling = true}));
  list.push_back(Entry<Terrazzo>("Terrazzo", "terrazzo", {.floor = true}));
}

}  // namespace parallax
