#include "worker/scene/types/nature/ground/ground.h"

#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <string>
#include <utility>

#include "worker/materials/kernel/surface.h"
#include "worker/materials/land/broken_rock.h"
#include "worker/scene/types/nature/rules/masks.h"

namespace parallax {
namespace {

constexpr float kLongestLedge_m = 4.3f;  // Wavelength; the mesh has what is longer.

std::vector<MaskOnGround> MasksOf(const v1::Terrain& recipe) {
  std::vector<MaskOnGround> masks;
  for (const v1::GroundRule& rule : recipe.ground()) masks.emplace_back(rule.mask());
  return masks;
}

class GroundMaterial final : public Material {
 public:
  GroundMaterial(const v1::Terrain& recipe, std::shared_ptr<const Terrain> terrain,
                 std::vector<GroundCover> covers)
      : terrain_(std::move(terrain)),
        covers_(std::move(covers)),
        masks_(MasksOf(recipe)),
        seed_(static_cast<uint32_t>(recipe.seed()) * 2654435761u + 17u),
        wind_(WindOf(recipe)) {}

  SurfaceSample8 Evaluate(const SurfacePoint8& points) const override {
    const std::vector<Float8> cover = CoversAt(points);
    const SurfacePoint8 in_wind = InWind(points);
    SurfaceSample8 sum = covers_[0].material->Evaluate(in_wind);
    Float8 frozen = Splat(covers_[0].frozen ? 1 : 0);
    for (size_t i = 1; i < covers_.size(); ++i) {
      if (!Any(cover[i] > 0)) continue;
      const SurfaceSample8 over = covers_[i].material->Evaluate(in_wind);
      sum.base_color = Mix(sum.base_color, over.base_color, cover[i]);
      sum.roughness += (over.roughness - sum.roughness) * cover[i];
      sum.specular += (over.specular - sum.specular) * cover[i];
      sum.sheen += (over.sheen - sum.sheen) * cover[i];
      frozen += ((covers_[i].frozen ? 1.0f : 0.0f) - frozen) * cover[i];
    }
    const Float8 rock = cover.back();
    Vec3x8 tone = Tone(points);
    if (Any(rock > 0)) tone = tone * (1.0f + rock * (RockTone(points) - 1.0f));
    // Snow is white all over: with the tone of dry and damp earth it would be beige here, blue
    // there.
    sum.base_color = Albedo(sum.base_color * Mix(tone, Vec3x8::All(Splat(1)), frozen));
    if (terrain_->water() != nullptr) Moisten(points, sum);
    sum.transmission = Splat(0);
    sum.opacity = Splat(1);
    sum.subsurface = Splat(0);
    return sum;
  }

  Float8 Height(const SurfacePoint8& points) const override {
    const std::vector<Float8> cover = CoversAt(points);
    const SurfacePoint8 in_wind = InWind(points);
    Float8 height = covers_[0].material->Height(in_wind);
    for (size_t i = 1; i < covers_.size(); ++i) {
      if (!Any(cover[i] > 0)) continue;
      height += (covers_[i].material->Height(in_wind) - height) * cover[i];
    }
    return height + cover.back() * Ledges(points.texture_m, points.footprint_m);
  }

  // The covers' own slopes are gentle beside the materials'.
  Dual8 Relief(const SurfacePoint8& points, const Tangents8& tangents) const override {
    const std::vector<Float8> cover = CoversAt(points);
    const SurfacePoint8 in_wind = InWind(points);
    Tangents8 along = tangents;
    for (Vec3x8& way : along.texture) way = InWind(way);
    Dual8 relief = covers_[0].material->Relief(in_wind, along);
    for (size_t i = 1; i < covers_.size(); ++i) {
      if (!Any(cover[i] > 0)) continue;
      const Dual8 over = covers_[i].material->Relief(in_wind, along);
      relief.value += (over.value - relief.value) * cover[i];
      relief.dx += (over.dx - relief.dx) * cover[i];
      relief.dy += (over.dy - relief.dy) * cover[i];
    }
    if (!Any(cover.back() > 0)) return relief;
    const DualVec8 p = ReliefPoint8(points, tangents).texture_m;
    return relief + cover.back() * Ledges(p, points.footprint_m);
  }
  float widest_relief_m() const override { return 0.5f * kLongestLedge_m; }

 private:
  // Darkens and shines ground that waves and seeping water wet; a film of water lies where waves
  // have just run off.
  void Moisten(const SurfacePoint8& points, SurfaceSample8& sum) const {
    const Water& water = *terrain_->water();
    const bool sea = water.spec().kind == WaterKind::kSea;
    const float dry_m = sea ? 0.2f + 0.03f * water.spec().wind_mps : 0.2f;
    Float8 above = Splat(Terrain::kDry);
    for (int lane = 0; lane < kLanes; ++lane) {
      const Vec2f p(points.texture_m.x[lane], points.texture_m.y[lane]);
      const float level = points.texture_m.z[lane] - water.Level(p);
      if (level < 2 * dry_m && water.FromShore(p) < water.reach_m()) above[lane] = level;
    }
    if (!Any(above < 2 * dry_m)) return;
    const Float8 ragged =
        noise::Fbm3(points.texture_m, 2.3f, 4, points.footprint_m, seed_ + 13, 0.55f);
    const Float8 at = above + 0.3f * dry_m * ragged;
    const Float8 wet = 1.0f - noise::SmoothStep(0.3f * dry_m, Splat(dry_m), at);
    const Float8 film = 1.0f - noise::SmoothStep(0.02f, Splat(0.5f * dry_m), at);
    sum.base_color *= 1.0f - 0.48f * wet;
    sum.roughness += (0.42f - sum.roughness) * 0.8f * wet;
    if (sea) sum.roughness += (0.14f - sum.roughness) * 0.75f * film;
    sum.specular += (0.4f - sum.specular) * wet;
    sum.sheen *= 1.0f - wet;
  }

  static Vec2f WindOf(const v1::Terrain& recipe) {
    for (const v1::TerrainTerm& term : recipe.cover()) {
      if (term.kind() != TermKindName(TermKind::kDunes)) continue;
      return Vec2d(std::cos(term.direction_rad()), std::sin(term.direction_rad())).cast<float>();
    }
    return Vec2f::UnitX();
  }
  // Materials have their ripples across x: the wind's direction.
  Vec3x8 InWind(const Vec3x8& p) const {
    return {wind_.x() * p.x + wind_.y() * p.y, wind_.x() * p.y - wind_.y() * p.x, p.z};
  }
  SurfacePoint8 InWind(const SurfacePoint8& points) const {
    SurfacePoint8 turned = points;
    turned.texture_m = InWind(points.texture_m);
    turned.texture_normal = InWind(points.texture_normal);
    return turned;
  }

  // Bare rock, the last rule, from blocks of metres down to chips.
  template <typename Vec>
  RealOf<Vec> Ledges(const Vec& p, Float8 footprint_m, uint32_t octaves = 5) const {
    return BrokenRock{kLongestLedge_m, octaves, seed_}.HeightAt(p, footprint_m);
  }

  // Beds of other stone, stains that water drew, lichen.
  Float8 RockTone(const SurfacePoint8& points) const {
    const Vec3x8& p = points.texture_m;
    const Float8 w = points.footprint_m;
    const Vec3x8 bent(p.x * 0.12f, p.y * 0.12f,
                      p.z + 1.5f * noise::Fbm3(p, 11.0f, 2, w, seed_ + 71));
    const Float8 beds = noise::Fbm3(bent, 2.6f, 4, w, seed_ + 72, 0.6f);
    const Float8 stains = noise::Fbm3(Vec3x8(p.x, p.y, 0.25f * p.z), 1.7f, 4, w, seed_ + 73, 0.6f);
    if (terrain_->spec().strata.bed_m > 0) {
      // Bedded rock has beds and streaks of its own.
      return Clamp(1.0f + 0.13f * beds + 0.11f * stains, 0.35f, 1.7f);
    }
    // Faces of massive rock differ by the stone and by what runs down them, over tens of metres;
    // recesses are darker, because dust and lichen stay there.
    const Float8 faces = noise::Fbm3(Vec3x8(p.x, p.y, 0.5f * p.z), 31.0f, 5, w, seed_ + 74, 0.6f);
    const Float8 recess = 0.3f - Ledges(p, w, 2) / 0.6f;
    const Float8 pattern = 0.05f * beds + 0.36f * stains + 0.4f * faces - 0.5f * recess;
    return Clamp(1.0f + pattern, 0.35f, 1.7f);
  }

  // How much of what lies below each rule covers, sharpened by detail of some decimetres: borders
  // are ragged, not a cross-fade.
  std::vector<Float8> CoversAt(const SurfacePoint8& points) const {
    std::vector<Float8> covers(masks_.size(), Splat(1));
    const Vec3x8& p = points.texture_m;
    const Float8 ragged = noise::Fbm3(p, 0.7f, 4, points.footprint_m, seed_ + 5, 0.6f);
    for (size_t i = 1; i < masks_.size(); ++i) {
      Float8 mask;
      for (int lane = 0; lane < kLanes; ++lane) {
        mask[lane] = lane < points.count || lane == 0
                         ? masks_[i].At(*terrain_, Vec2f(p.x[lane], p.y[lane]))
                         : mask[lane - 1];
      }
      const Float8 open = 4.0f * mask * (1.0f - mask);
      covers[i] = noise::Saturate(mask + open * (ragged * 1.4f));
    }
    return covers;
  }

  // Nothing outdoors has one colour over ten metres: broad patches, lighter and drier or darker.
  Vec3x8 Tone(const SurfacePoint8& points) const {
    const Vec3x8& p = points.texture_m;
    const Float8 w = points.footprint_m;
    const Float8 broad = noise::Fbm3(p, 37.0f, 3, w, seed_, 0.55f);
    const Float8 middle = noise::Fbm3(p, 5.3f, 3, w, seed_ + 3, 0.55f);
    const Float8 dry = noise::Fbm3(p, 90.0f, 4, w, seed_ + 9, 0.6f);
    const Float8 value = 1.0f + 0.32f * broad + 0.22f * middle;
    return {value * (1.0f + 0.22f * dry), value * (1.0f + 0.06f * dry),
            value * (1.0f - 0.15f * dry)};
  }

  const std::shared_ptr<const Terrain> terrain_;
  const std::vector<GroundCover> covers_;
  const std::vector<MaskOnGround> masks_;
  const uint32_t seed_;
  const Vec2f wind_;  // Unit; along x where no dunes say where it blows to.
};

}  // namespace

void AssignGroundSlots(const v1::Terrain& recipe, const Terrain& terrain, Mesh& mesh) {
  const std::vector<MaskOnGround> masks = MasksOf(recipe);
  mesh.slots.clear();
  for (size_t i = 0; i < masks.size(); ++i) {
    mesh.slots.push_back({fmt::format("rule_{}", i), {"soil"}, false});
  }
  tbb::parallel_for(size_t{0}, mesh.triangles.size(), [&](size_t t) {
    Triangle& triangle = mesh.triangles[t];
    const Vec3f middle =
        (mesh.positions[triangle.a] + mesh.positions[triangle.b] + mesh.positions[triangle.c]) / 3;
    float left = 1, most = 0;  // `left`: what the rules above this one leave uncovered.
    for (size_t i = masks.size(); i-- > 0;) {
      const float cover = i == 0 ? 1 : masks[i].At(terrain, middle.head<2>());
      if (left * cover > most) {
        most = left * cover;
        triangle.slot = static_cast<uint16_t>(i);
      }
      left *= 1 - cover;
    }
  });
}

std::shared_ptr<const Material> MakeGroundMaterial(const v1::Terrain& recipe,
                                                   std::shared_ptr<const Terrain> terrain,
                                                   std::vector<GroundCover> covers) {
  return std::make_shared<const GroundMaterial>(recipe, std::move(terrain), std::move(covers));
}

}  // namespace parallax
