// Family `wood`: boards of eight species, floor planks, herringbone parquet, plywood edges.
#include "worker/materials/families.h"
#include "worker/materials/wood_grain.h"

namespace parallax {
namespace {

using noise::Hash;
using noise::UnitByte;

Vec3f FaceOf(const SurfacePoint& point) {
  return point.texture_normal != Vec3f::Zero() ? point.texture_normal : point.normal;
}

// One piece of solid wood.
class Board final : public Material {
 public:
  Board(Rng& rng, const WoodSpecies& species) : grain_(rng, species), finish_(rng) {}
  SurfaceSample Evaluate(const SurfacePoint& point) const override {
    SurfaceSample out;
    finish_.Apply(grain_.At(point.texture_m, FaceOf(point), point.footprint_m), out);
    return out;
  }
  float Height(const SurfacePoint& point) const override {
    return grain_.HeightAt(point.texture_m, point.footprint_m);
  }

 private:
  WoodGrain grain_;
  WoodFinish finish_;
};

// Where a point lies in a floor of laid pieces.
struct Piece {
  float along_m = 0, across_m = 0;  // From the piece's corner; along the grain of this piece.
  float edge_m = 0;                 // To its nearest edge.
  uint32_t id = 0;
};

// What planks and parquet share: a piece of wood, its own tint and place in the tree, and the gap
// around it.
class LaidWood : public Material {
 public:
  SurfaceSample Evaluate(const SurfacePoint& point) const final {
    const Piece piece = At(OnPlane(point));
    const WoodGrain::Point grain = grain_.At(InTree(piece), Vec3f::UnitZ(), point.footprint_m);
    SurfaceSample out;
    finish_.Apply(grain, out);
    const float spread = spread_ * noise::Fade(2.5f * width_m_, point.footprint_m);
    const float tone = 1.0f + spread * (UnitByte(piece.id, 0) - 0.5f);
    const float warm = 1.0f + 0.25f * spread * (UnitByte(piece.id, 1) - 0.5f);
    out.base_color = out.base_color.cwiseProduct(Vec3f(tone * warm, tone, tone / warm));
    const float inside = Inside(piece, point.footprint_m);
    out.base_color = Albedo(Mix(out.base_color * 0.22f, out.base_color, inside));
    out.roughness = noise::Lerp(0.8f, out.roughness, inside);
    out.clearcoat *= inside;
    return out;
  }
  float Height(const SurfacePoint& point) const final {
    const Piece piece = At(OnPlane(point));
    const float bevel =
        noise::SmoothStep(0.0f, std::max(bevel_m_, 2.0f * point.footprint_m), piece.edge_m);
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
  virtual Piece At(const PlanePoint& plane) const = 0;

  float width_m_ = 0.1f;  // Of a piece; the subclass draws it.

 private:
  static Vec3f InTree(const Piece& piece) {
    return {piece.along_m + 7.0f * UnitByte(piece.id, 1),
            piece.across_m + 0.35f * (UnitByte(piece.id, 2) - 0.5f),
            0.5f * (UnitByte(piece.id, 3) - 0.5f)};
  }
  float Inside(const Piece& piece, float footprint_m) const {
    // A gap of 0.8 mm; once it is finer than the footprint it only darkens its surroundings by its
    // share.
    const float width = std::max(0.0008f, footprint_m);
    return 1.0f - (0.0008f / width) * (1.0f - noise::SmoothStep(0.3f * width, width, piece.edge_m));
  }

  WoodGrain grain_;
  WoodFinish finish_;
  float spread_, bevel_m_, depth_m_;
};

// Floor boards along x with staggered ends.
class WoodPlanks final : public LaidWood {
 public:
  explicit WoodPlanks(Rng& rng, const WoodSpecies& species) : LaidWood(rng, species) {
    width_m_ = Draw(rng, 0.07, 0.19);
    length_m_ = width_m_ * Draw(rng, 7, 13);
    seed_ = DrawSeed(rng);
  }

 private:
  Piece At(const PlanePoint& plane) const override {
    const float row = plane.v / width_m_ + 0.5f;
    const int j = noise::FloorInt(row);
    const float along = plane.u / length_m_ + noise::Unit(Hash(j, seed_));
    const int i = noise::FloorInt(along);
    Piece piece;
    piece.along_m = (along - static_cast<float>(i)) * length_m_;
    piece.across_m = (row - static_cast<float>(j)) * width_m_;
    piece.edge_m = std::min(std::min(piece.along_m, length_m_ - piece.along_m),
                            std::min(piece.across_m, width_m_ - piece.across_m));
    piece.id = Hash(i, j, seed_ + 1);
    return piece;
  }

  float length_m_;
  uint32_t seed_;
};

// Herringbone: on a grid of unit squares, (i - j) mod 2n tells a lying block (< n) from a standing
// one.
class ParquetHerringbone final : public LaidWood {
 public:
  explicit ParquetHerringbone(Rng& rng, const WoodSpecies& species) : LaidWood(rng, species) {
    width_m_ = Draw(rng, 0.05, 0.09);
    n_ = rng.UniformInt(4, 6);
    seed_ = DrawSeed(rng);
  }

 private:
  Piece At(const PlanePoint& plane) const override {
    // Laid at 45 degrees to the walls.
    const float a = (plane.u + plane.v) * 0.70710678f / width_m_;
    const float b = (plane.v - plane.u) * 0.70710678f / width_m_;
    const int i = noise::FloorInt(a), j = noise::FloorInt(b);
    const float x = a - static_cast<float>(i), y = b - static_cast<float>(j);
    const int k = (((i - j) % (2 * n_)) + 2 * n_) % (2 * n_);
    Piece piece;
    const float length = static_cast<float>(n_);
    float along, across;
    if (k < n_) {
      along = static_cast<float>(k) + x;
      across = y;
      piece.id = Hash(i - k, j, seed_);
    } else {
      const int m = 2 * n_ - 1 - k;
      along = static_cast<float>(m) + y;
      across = x;
      piece.id = Hash(i, j - m, seed_ + 1);
    }
    piece.along_m = along * width_m_;
    piece.across_m = across * width_m_;
    piece.edge_m =
        width_m_ * std::min(std::min(along, length - along), std::min(across, 1 - across));
    return piece;
  }

  int n_;
  uint32_t seed_;
};

// Cross-bonded veneers seen from the side: layers across z alternate long grain and end grain.
class PlywoodEdge final : public Material {
 public:
  explicit PlywoodEdge(Rng& rng) : grain_(rng, kBeech) {
    layer_m_ = Draw(rng, 0.0011, 0.0022);
    roughness_ = Draw(rng, 0.5, 0.65);
    end_grain_ = Draw(rng, 0.45, 0.65);
    seed_ = DrawSeed(rng);
  }
  SurfaceSample Evaluate(const SurfacePoint& point) const override {
    const float w = point.footprint_m;
    const float t = point.texture_m.z() / layer_m_;
    const int layer = noise::FloorInt(t);
    const float phase = t - static_cast<float>(layer);
    const float fade = noise::Fade(2.0f * layer_m_, w);
    const float soft = std::max(0.12f, w / layer_m_);
    const float edge =
        noise::SmoothStep(0.0f, soft, phase) * noise::SmoothStep(0.0f, soft, 1 - phase);
    const float cross = (layer & 1) ? 1.0f : 0.0f;
    const float dark = 0.5f + (cross * edge + 0.5f * (1 - edge) - 0.5f) * fade;
    const Vec3f& p = point.texture_m;
    const WoodGrain::Point grain = grain_.At(p, Vec3f::UnitY(), w);
    // End grain: short specks instead of lines.
    const float speck = noise::Fbm3(Vec3f(p.x(), p.y(), p.z() * 2.0f), 0.0016f, 2, w, seed_);
    const float tone = 1.0f - (1.0f - end_grain_) * dark * (1.0f + 0.5f * speck);
    const float sheet = 1.0f + 0.08f * fade * (UnitByte(Hash(layer, seed_), 0) - 0.5f);
    SurfaceSample out;
    out.base_color = Albedo(grain.color * (tone * sheet));
    out.roughness = roughness_;
    out.specular = 0.35f;
    return out;
  }
  float Height(const SurfacePoint& point) const override {
    const float phase = noise::Fract(point.texture_m.z() / (2.0f * layer_m_));
    return -4e-5f * (0.5f + 0.5f * noise::CosTurn(phase)) *
               noise::Fade(2.0f * layer_m_, point.footprint_m) +
           2e-5f * noise::Fbm3(point.texture_m, 0.0016f, 2, point.footprint_m, seed_);
  }

 private:
  WoodGrain grain_;
  float layer_m_, roughness_, end_grain_;
  uint32_t seed_;
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
