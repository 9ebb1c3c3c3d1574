// Flotsam of the shore: shells, wrack, ice floes.
#include <algorithm>
#include <cmath>
#include <functional>

#include "worker/assets/kernel/detail_scope.h"
#include "worker/assets/nature/ground_cover.h"
#include "worker/assets/nature/limb.h"
#include "worker/assets/nature/plant_detail.h"
#include "worker/assets/nature/sheets.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A disc of rings about the origin; each ring is an outline of its own height.
class RingBody {
 public:
  RingBody(Mesh& mesh, int sides) : mesh_(mesh), sides_(static_cast<uint32_t>(sides)) {}

  // Starts a surface with sharp rims: its vertices are its own.
  void Begin(uint16_t slot) {
    slot_ = slot;
    first_vertex_ = mesh_.positions.size();
    first_triangle_ = mesh_.triangles.size();
    rings_ = 0;
  }
  void AddRing(const std::function<Vec3f(float angle)>& at) {
    const auto first = static_cast<uint32_t>(mesh_.positions.size());
    for (uint32_t k = 0; k < sides_; ++k) {
      AddPoint(at(2 * kPi * static_cast<float>(k) / static_cast<float>(sides_)));
    }
    if (rings_++ == 0) return;
    for (uint32_t k = 0; k < sides_; ++k) {
      const uint32_t next = (k + 1) % sides_;
      const uint32_t a = first - sides_ + k, b = first - sides_ + next, c = first + next,
                     d = first + k;
      mesh_.triangles.push_back({a, b, c, slot_});
      mesh_.triangles.push_back({a, c, d, slot_});
    }
  }
  // Closes the last ring with a fan about a point; `below`: that looks down.
  void Close(const Vec3f& middle, bool below = false) {
    const auto center = static_cast<uint32_t>(mesh_.positions.size());
    AddPoint(middle);
    for (uint32_t k = 0; k < sides_; ++k) {
      uint32_t a = center - sides_ + k, b = center - sides_ + (k + 1) % sides_;
      if (below) std::swap(a, b);
      mesh_.triangles.push_back({a, b, center, slot_});
    }
  }
  void End() { SetNormals(mesh_, first_vertex_, first_triangle_); }

 private:
  void AddPoint(const Vec3f& p) {
    mesh_.positions.push_back(p);
    mesh_.normals.push_back(Vec3f::UnitZ());
    mesh_.texture.push_back(p);
    mesh_.uv.push_back(Vec2f::Zero());
  }

  Mesh& mesh_;
  const uint32_t sides_;
  uint16_t slot_ = 0;
  size_t first_vertex_ = 0, first_triangle_ = 0;
  int rings_ = 0;
};

Asset MakeShells(const LitterParams& p) {
  Rng rng(SceneSeed{p.seed}, "shells");
  SheetGrower shells(SheetSlot("shells", {"SeaShell"}), rng.Child("shells"));
  const bool near = CurrentDetail() == PlantDetail::kNear;
  // Halves of mussels and cockles: their domes lie up or down.
  std::vector<SheetTemplate> forms;
  for (const float width : {0.55f, 0.95f}) {
    for (const float dome : {-1.1f, 1.1f}) {
      forms.push_back(
          MakeLeafTemplate({LeafShape::kPetal, width, dome, 0.35f * dome, near ? 5 : 2, 0}));
    }
  }
  for (int k = 0; k < p.count; ++k) {
    const float a = Draw(rng, 0, 2 * kPi), r = p.radius_m * std::sqrt(Draw(rng, 0, 1));
    const float turn = Draw(rng, 0, 2 * kPi), length = Draw(rng, 0.018, 0.055);
    SheetPlace place;
    place.at = {r * std::cos(a), r * std::sin(a), 0.15f * length};
    place.along = {std::cos(turn), std::sin(turn), Draw(rng, -0.1, 0.35)};
    place.up = {Draw(rng, -0.3, 0.3), Draw(rng, -0.3, 0.3), 1};
    place.length_m = length;
    shells.Add(forms[static_cast<size_t>(rng.UniformInt(0, 3))], place);
  }
  return FinishMeshes({&shells.mesh()}, p.seed);
}

// Seaweed at the tide's line.
Asset MakeWrack(const LitterParams& p) {
  Rng rng(SceneSeed{p.seed}, "wrack");
  SheetGrower ribbons(SheetSlot("ribbons", {"Seaweed"}), rng.Child("ribbons"));
  const bool near = CurrentDetail() == PlantDetail::kNear;
  std::vector<SheetTemplate> forms;
  for (const float curl : {-0.2f, 0.12f, 0.3f}) {
    LeafForm form{LeafShape::kBlade, 0.1f, curl, 0.1f, near ? 6 : 3, 0};
    form.twist = 1.5f * curl;
    forms.push_back(MakeLeafTemplate(form));
  }
  for (int k = 0; k < p.count; ++k) {
    // Drawn out along x, as the tide's line runs.
    const float layer = static_cast<float>(k) / static_cast<float>(p.count);
    const float x = p.radius_m * Draw(rng, -1, 1), y = 0.42f * p.radius_m * Draw(rng, -1, 1);
    const float a = Draw(rng, 0, 2 * kPi);
    SheetPlace place;
    place.at = {x, y, 0.004f + 0.05f * layer * (1 - std::abs(x) / p.radius_m)};
    place.along = {std::cos(a), 0.6f * std::sin(a), Draw(rng, -0.08, 0.06)};
    place.up = {Draw(rng, -0.3, 0.3), Draw(rng, -0.3, 0.3), 1};
    place.length_m = Draw(rng, 0.12, 0.42);
    ribbons.Add(forms[static_cast<size_t>(rng.UniformInt(0, 2))], place);
  }
  return FinishMeshes({&ribbons.mesh()}, p.seed);
}

// A flat piece of floating ice.
struct IceFloeParams {
  float radius_m = 1;
  float thick_m = 0.28f;
  int sides = 7;  // Sides of the polygon that broke off.
  uint64_t seed = 0;
};

// A polygon with worn corners: distances of some sides, the nearest counts.
class FloeForm {
 public:
  FloeForm(const IceFloeParams& p, Rng& rng) : p_(p), noise_(rng) {
    for (int k = 0; k < p.sides; ++k) {
      sides_.push_back(
          {2 * kPi * (static_cast<float>(k) + Draw(rng, -0.3, 0.3)) / static_cast<float>(p.sides),
           Draw(rng, 0.68, 1.0)});
    }
  }

  // Height of the upper face at q, `share` of the way from the middle to the rim.
  float Top(const Vec2f& q, float share) const {
    const Vec3f on(q.x(), q.y(), 0.7f);
    return p_.thick_m * (1 + 0.16f * noise_.Fractal(0.9f * on, 3)) +
           0.05f * noise_.Fractal(4.0f * on, 2) - 0.06f * std::pow(share, 8.0f);
  }
  // The point of the upper face at an angle.
  Vec3f OnTop(float a, float share) const {
    const float r = share * Outline(a);
    const Vec2f q(r * std::cos(a), r * std::sin(a));
    return Vec3f(q.x(), q.y(), Top(q, share));
  }
  // The point of the side at an angle; `s`: 0 at the bottom, 1 at the rim.
  Vec3f OnSide(float a, float s) const {
    const Vec3f rim = OnTop(a, 1);
    if (s >= 1) return rim;
    const Vec3f at(2.5f * rim.x(), 2.5f * rim.y(), 9 * s * rim.z());
    // The water line lies at two thirds; ice is thinner there, and broader below.
    const float lap = std::exp(-std::pow((s - 0.62f) / 0.16f, 2.0f));
    const float out = 1 + 0.03f * noise_.Fractal(at, 3) - 0.05f * lap + 0.05f * (1 - s);
    return Vec3f(rim.x() * out, rim.y() * out, s * rim.z());
  }

 private:
  struct Side {
    float angle, distance;
  };

  float Outline(float a) const {
    float sum = 0;
    for (const Side& side : sides_) {
      const float facing = std::cos(a - side.angle);
      if (facing > 0.05f) sum += std::pow(facing / side.distance, 16.0f);
    }
    const Vec3f on(1.7f * std::cos(a), 1.7f * std::sin(a), 0.4f);
    return p_.radius_m * std::min(1.3f, std::pow(sum, -1 / 16.0f)) *
           (1 + 0.05f * noise_.Fractal(2.2f * on, 3));
  }

  const IceFloeParams& p_;
  const Noise noise_;
  std::vector<Side> sides_;
};

// The origin is in the middle of its lower side.
Asset MakeIceFloe(const IceFloeParams& p) {
  Rng rng(SceneSeed{p.seed}, "floe");
  const FloeForm form(p, rng);
  Mesh mesh{.slots = {Slot("snow", {"PackedSnow"}), Slot("ice", {"SeaIce"})}};
  const float pieces = 2 * kPi * p.radius_m / std::max(0.055f, TargetEdge());
  RingBody body(mesh, std::clamp(4 * static_cast<int>(pieces / 4), 16, 96));

  // The top, from the rim inwards.
  const int rings = std::clamp(static_cast<int>(p.radius_m / std::max(0.07f, TargetEdge())), 4, 16);
  body.Begin(0);
  for (int k = rings; k >= 1; --k) {
    const float share = static_cast<float>(k) / static_cast<float>(rings);
    body.AddRing([&](float a) { return form.OnTop(a, share); });
  }
  body.Close(Vec3f(0, 0, form.Top(Vec2f::Zero(), 0)));
  body.End();

  // The side, and the underside.
  body.Begin(1);
  constexpr int kLayers = 7;
  for (int k = 0; k <= kLayers; ++k) {
    body.AddRing([&](float a) { return form.OnSide(a, static_cast<float>(k) / kLayers); });
  }
  body.End();
  body.Begin(1);
  body.AddRing([&](float a) { return form.OnSide(a, 0); });
  body.Close(Vec3f::Zero(), true);
  body.End();
  return FinishMeshes({&mesh}, p.seed);
}

}  // namespace

Asset SampleShells(Rng& rng) {
  return MakeShells(
      {.radius_m = Draw(rng, 0.15, 0.5), .count = rng.UniformInt(10, 34), .seed = rng.Seed()});
}

Asset SampleWrack(Rng& rng) {
  return MakeWrack(
      {.radius_m = Draw(rng, 0.25, 0.6), .count = rng.UniformInt(60, 140), .seed = rng.Seed()});
}

Asset SampleIceFloe(Rng& rng) {
  return MakeIceFloe({.radius_m = Draw(rng, 0.7, 1.2),
                      .thick_m = Draw(rng, 0.2, 0.34),
                      .sides = rng.UniformInt(5, 9),
                      .seed = rng.Seed()});
}

}  // namespace parallax
