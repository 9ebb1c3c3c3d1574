// Family `wood`: boards of eight species, floor planks, herringbone parquet, plywood edges.
#include "worker/materials/kernel/material_families.h"
#include "worker/materials/kernel/wood_grain.h"

namespace parallax {
namespace {

using namespace noise;  // NOLINT: the vocabulary of patterns.

// One piece of solid wood.
class Board final : public Carved<Board> {
 public:
  Board(Rng& rng, const WoodSpecies& species) : grain_(rng, species), finish_(rng) {}
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    SurfaceSample8 out;
    finish_.Apply(grain_.At(point.texture_m, FaceOf(point), point.footprint_m), out);
    return out;
  }
  auto HeightOf(const auto& point) const {
    return grain_.HeightAt(point.texture_m, point.footprint_m);
  }

 private:
  WoodGrain grain_;
  WoodFinish finish_;
};

// Where a point lies in a floor of laid pieces.
template <typename Real>
struct Piece {
  Real along_m, across_m;  // From the piece's corner; along the grain of this piece.
  Real edge_m;             // To its nearest edge.
  Bits8 id;
};

// Common to planks and parquet: a piece of wood, its own tint and place in the tree, and the gap
// around it. `Self` knows how pieces are laid: `Piece<Real> At(const PlaneOf8<Real>&)`.
template <typename Self>
class LaidWood : public Carved<Self> {
 public:
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const final {
    const auto piece = PieceAt(point);
    const WoodGrain::Point grain =
        grain_.At(InTree(piece), Vec3x8(Vec3f::UnitZ()), point.footprint_m);
    SurfaceSample8 out;
    finish_.Apply(grain, out);
    const Float8 spread = spread_ * noise::Fade(2.5f * width_m_, point.footprint_m);
    const Float8 tone = 1.0f + spread * (UnitByte(piece.id, 0) - 0.5f);
    const Float8 warm = 1.0f + 0.25f * spread * (UnitByte(piece.id, 1) - 0.5f);
    out.base_color = out.base_color * Vec3x8(tone * warm, tone, tone / warm);
    const Float8 inside = Inside(piece, point.footprint_m);
    out.base_color = Albedo(Mix(out.base_color * 0.22f, out.base_color, inside));
    out.roughness = noise::Lerp(0.8f, out.roughness, inside);
    out.clearcoat *= inside;
    return out;
  }
  auto HeightOf(const auto& point) const {
    const auto piece = PieceAt(point);
    const auto bevel =
        noise::SmoothStep(0.0f, Max(bevel_m_, 2.0f * point.footprint_m), piece.edge_m);
    // The grain fades out at the edge: neighbours come from elsewhere in the tree, and relief must
    // not jump.
    return bevel * grain_.HeightAt(InTree(piece), point.footprint_m) -
           depth_m_ * (1.0f - bevel) * noise::Fade(0.02f, point.footprint_m);
  }

 protected:
  LaidWood(Rng& rng, const WoodSpecies& species) : grain_(rng, species), finish_(rng) {
    spread_ = Draw(rng, 0.15, 0.5);
    bevel_m_ = Draw(rng, 0.0015, 0.004);
    depth_m_ = Draw(rng, 0.0004, 0.0012);
  }

  float width_m_ = 0.1f;  // Width of a piece; the subclass draws it.

 private:
  auto PieceAt(const auto& point) const {
    return static_cast<const Self*>(this)->At(OnPlane(point));
  }
  template <typename Real>
  static auto InTree(const Piece<Real>& piece) {
    return VecOf(piece.along_m + 7.0f * UnitByte(piece.id, 1),
                 piece.across_m + 0.35f * (UnitByte(piece.id, 2) - 0.5f),
                 Real(0.5f * (UnitByte(piece.id, 3) - 0.5f)));
  }
  Float8 Inside(const Piece<Float8>& piece, Float8 footprint_m) const {
    // A gap of 0.8 mm; once it is finer than the footprint it only darkens its surroundings by its
    // share.
    const Float8 width = Max(0.0008f, footprint_m);
    return 1.0f - (0.0008f / width) * (1.0f - noise::SmoothStep(0.3f * width, width, piece.edge_m));
  }

  WoodGrain grain_;
  WoodFinish finish_;
  float spread_, bevel_m_, depth_m_;
};

// Floor boards along x with staggered ends.
class WoodPlanks final : public LaidWood<WoodPlanks> {
 public:
  explicit WoodPlanks(Rng& rng, const WoodSpecies& species) : LaidWood(rng, species) {
    width_m_ = Draw(rng, 0.07, 0.19);
    length_m_ = width_m_ * Draw(rng, 7, 13);
    seed_ = DrawSeed(rng);
  }
  template <typename Real>
  Piece<Real> At(const PlaneOf8<Real>& plane) const {
    const Real row = plane.v / width_m_ + 0.5f;
    const Int8 j = noise::FloorInt(row);
    const Real along = plane.u / length_m_ + noise::Unit(Hash(j, seed_));
    const Int8 i = noise::FloorInt(along);
    Piece<Real> piece;
    piece.along_m = (along - ToFloat(i)) * length_m_;
    piece.across_m = (row - ToFloat(j)) * width_m_;
    piece.edge_m = Min(Min(piece.along_m, length_m_ - piece.along_m),
                       Min(piece.across_m, width_m_ - piece.across_m));
    piece.id = Hash(i, j, seed_ + 1);
    return piece;
  }

 private:
  float length_m_;
};

// Herringbone: on a grid of unit squares, (i - j) mod 2n tells a lying block (< n) from a standing
// one.
class ParquetHerringbone final : public LaidWood<ParquetHerringbone> {
 public:
  explicit ParquetHerringbone(Rng& rng, const WoodSpecies& species) : LaidWood(rng, species) {
    width_m_ = Draw(rng, 0.05, 0.09);
    n_ = rng.UniformInt(4, 6);
    seed_ = DrawSeed(rng);
  }
  template <typename Real>
  Piece<Real> At(const PlaneOf8<Real>& plane) const {
    // Laid at 45 degrees to the walls.
    const Real a = (plane.u + plane.v) * 0.70710678f / width_m_;
    const Real b = (plane.v - plane.u) * 0.70710678f / width_m_;
    const Int8 i = noise::FloorInt(a), j = noise::FloorInt(b);
    const Real x = a - ToFloat(i), y = b - ToFloat(j);
    // The quotient is exact enough for its floor as long as i - j fits into a float.
    const float length = static_cast<float>(n_);
    const Int8 k = i - j - 2 * n_ * noise::FloorInt(ToFloat(i - j) / (2.0f * length));
    const Int8 m = 2 * n_ - 1 - k;
    const Mask8 lying = k < n_;
    const Real along = Select(lying, ToFloat(k) + x, ToFloat(m) + y);
    const Real across = Select(lying, y, x);
    Piece<Real> piece;
    piece.id = lying ? Hash(i - k, j, seed_) : Hash(i, j - m, seed_ + 1);
    piece.along_m = along * width_m_;
    piece.across_m = across * width_m_;
    piece.edge_m = width_m_ * Min(Min(along, length - along), Min(across, 1.0f - across));
    return piece;
  }

 private:
  int n_;
};

// Cross-bonded veneers seen from the side: layers across z alternate long grain and end grain.
class PlywoodEdge final : public Carved<PlywoodEdge> {
 public:
  explicit PlywoodEdge(Rng& rng) : grain_(rng, kBeech) {
    layer_m_ = Draw(rng, 0.0011, 0.0022);
    roughness_ = Draw(rng, 0.5, 0.65);
    end_grain_ = Draw(rng, 0.45, 0.65);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample8 Evaluate(const SurfacePoint8& point) const override {
    const Float8 w = point.footprint_m;
    const Float8 t = point.texture_m.z / layer_m_;
    const Int8 layer = noise::FloorInt(t);
    const Float8 phase = t - ToFloat(layer);
    const Float8 fade = noise::Fade(2.0f * layer_m_, w);
    const Float8 soft = Max(0.12f, w / layer_m_);
    const Float8 edge =
        noise::SmoothStep(0.0f, soft, phase) * noise::SmoothStep(0.0f, soft, 1.0f - phase);
    const Float8 cross = ToFloat(layer & 1);
    const Float8 dark = 0.5f + (cross * edge + 0.5f * (1.0f - edge) - 0.5f) * fade;
    const Vec3x8& p = point.texture_m;
    const WoodGrain::Point grain = grain_.At(p, Vec3x8(Vec3f::UnitY()), w);
    // End grain: short specks instead of lines.
    const Float8 speck = noise::Fbm3(Vec3x8(p.x, p.y, p.z * 2.0f), 0.0016f, 2, w, seed_);
    const Float8 tone = 1.0f - (1.0f - end_grain_) * dark * (1.0f + 0.5f * speck);
    const Float8 sheet = 1.0f + 0.08f * fade * (UnitByte(Hash(layer, seed_), 0) - 0.5f);
    return {.base_color = Albedo(grain.color * (tone * sheet)),
            .roughness = Splat(roughness_),
            .specular = Splat(0.35f)};
  }
  auto HeightOf(const auto& point) const {
    const auto phase = noise::Fract(point.texture_m.z / (2.0f * layer_m_));
    return -4e-5f * (0.5f + 0.5f * noise::CosTurn(phase)) *
               noise::Fade(2.0f * layer_m_, point.footprint_m) +
           2e-5f * noise::Fbm3(point.texture_m, 0.0016f, 2, point.footprint_m, seed_);
  }

 private:
  WoodGrain grain_;
  float layer_m_, roughness_, end_grain_;
};

}  // namespace

void AddWoodMaterials(MaterialList& list) {
  const MaterialTags board = {.diffuse = true};
  const MaterialTags laid = {.diffuse = true, .floor = true, .any_object = false};
  const auto add_board = [&](const char* name, const WoodSpecies& species) {
    list.push_back(Entry<Board>(name, "wood", board, species));
  };
  add_board("AshWood", kAsh);
  add_board("BeechWood", kBeech);
  add_board("CherryWood", kCherry);
  add_board("EbonyWood", kEbony);
  add_board("MahoganyWood", kMahogany);
  add_board("OakWood", kOak);
  add_board("PineWood", kPine);
  add_board("WalnutWood", kWalnut);
  list.push_back(Entry<PlywoodEdge>("PlywoodEdge", "wood", {.diffuse = true, .any_object = false}));
  list.push_back(Entry<WoodPlanks>("WoodPlanks", "wood", laid, kOak));
  list.push_back(Entry<WoodPlanks>("WalnutPlanks", "wood", laid, kWalnut));
  list.push_back(Entry<ParquetHerringbone>("ParquetHerringbone", "wood", laid, kOak));
}

}  // namespace parallax
