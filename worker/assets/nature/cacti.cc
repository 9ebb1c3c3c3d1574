// Cacti: columns, barrels, pads.
#include <algorithm>
#include <cmath>

#include "worker/assets/nature/ground_cover.h"
#include "worker/assets/nature/limb.h"
#include "worker/assets/nature/plant_detail.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A limb of a cactus: ribs along it, cushions of spines on their crests.
struct CactusLimb {
  std::vector<LimbRing> rings;
  int ribs = 14;
  float depth = 0.16f;       // Depth of the grooves, in radii.
  float cushion_m = 0.075f;  // Between two cushions of a rib.
  float spine_m = 0.035f;
};

class CactusGrower {
 public:
  explicit CactusGrower(uint64_t seed)
      : rng_(SceneSeed{seed}, "cactus"),
        spines_(SheetSlot("spines", {"DryGrass"}), rng_.Child("spines")) {
    body_.slots.push_back(Slot("flesh", {"CactusSkin"}));
    for (int i = 0; i < 3; ++i) templates_.push_back(MakeTuftTemplate(4, 1.35f, 0.04f, rng_));
  }

  Rng& rng() { return rng_; }

  void Add(const CactusLimb& limb) {
    const int a_rib = ByDetail<int>({5, 4, 2, 1}), sides = std::max(8, a_rib * limb.ribs);
    const auto ribs = static_cast<float>(limb.ribs);
    const auto groove = [ribs](float angle) {
      return std::pow(std::abs(std::sin(0.5f * ribs * angle)), 1.6f);
    };
    LimbOptions options{.sides = sides};
    if (a_rib > 1) {
      options.modulate = [&](float angle, float) { return 1 - limb.depth * groove(angle); };
    }
    options.texture_offset_m = {Draw(rng_, -20, 20), 0, 0};
    const size_t first = body_.positions.size();
    AddLimb(body_, limb.rings, options);
    // The order of AddLimb's vertices: ring after ring.
    const size_t whole = (limb.rings.size() - 1) * static_cast<size_t>(sides);
    for (size_t i = 0; i < whole; ++i) {
      const float angle =
          2 * kPi * static_cast<float>(i % static_cast<size_t>(sides)) / static_cast<float>(sides);
      const float along = body_.texture[first + i].x() - options.texture_offset_m.x();
      body_.uv[first + i] = {groove(angle), along / limb.cushion_m};
    }
    if (CurrentDetail() == PlantDetail::kNear) AddSpines(limb);
  }

  // A pad: flat, wider towards its end.
  void AddPad(const Vec3f& at, const Vec3f& way, float turn, float length) {
    CactusLimb limb;
    constexpr int kRings = 9;
    for (int k = 0; k <= kRings; ++k) {
      const float s = static_cast<float>(k) / kRings;
      const float wide = std::pow(std::max(0.0f, std::sin(kPi * std::pow(s, 1.25f))), 0.62f);
      limb.rings.push_back(
          {at + s * length * way, std::max(0.012f * length, 0.42f * length * wide)});
    }
    LimbOptions options;
    options.sides = ByDetail<int>({24, 16, 10, 8});
    options.modulate = [turn](float angle, float) {
      const float c = std::cos(angle - turn), s = std::sin(angle - turn) / 0.17f;
      return 1 / std::sqrt(c * c + s * s);
    };
    options.texture_offset_m = {Draw(rng_, -20, 20), 0, 0};
    const size_t first = body_.positions.size();
    AddLimb(body_, limb.rings, options);
    const auto sides = static_cast<size_t>(options.sides);
    // Cushions in a lattice: rows across, offset by turns, told by how far out they are.
    for (size_t i = 0; i < kRings * sides; ++i) {
      const Vec3f texture = body_.texture[first + i] - options.texture_offset_m;
      const float out = std::sqrt(texture.y() * texture.y() + texture.z() * texture.z());
      body_.uv[first + i] = {std::abs(std::sin(kPi * out / (0.16f * length))),
                             texture.x() / (0.16f * length)};
    }
  }

  Asset Finish(uint64_t seed) {
    AssetBuilder b(seed);
    b.AddMesh(body_, Eigen::Affine3f::Identity());
    if (!spines_.mesh().triangles.empty()) b.AddMesh(spines_.mesh(), Eigen::Affine3f::Identity());
    return b.Finish(Anchor::kGround);
  }

 private:
  void AddSpines(const CactusLimb& limb) {
    float along = 0, next = 0;
    for (size_t i = 1; i < limb.rings.size(); ++i) {
      const Vec3f from = limb.rings[i - 1].at, step = limb.rings[i].at - from;
      const float length = step.norm();
      if (length <= 0) continue;
      for (; next < along + length; next += limb.cushion_m) {
        const float s = (next - along) / length;
        const float radius = Lerp(limb.rings[i - 1].radius, limb.rings[i].radius, s);
        AddRow(limb, from + s * step, step / length, radius);
      }
      along += length;
    }
  }
  // One cushion on each rib.
  void AddRow(const CactusLimb& limb, const Vec3f& at, const Vec3f& along, float radius) {
    const Vec3f x =
        along.cross(std::abs(along.x()) < 0.8f ? Vec3f::UnitX() : Vec3f::UnitY()).normalized();
    const Vec3f y = along.cross(x);
    for (int k = 0; k < limb.ribs; ++k) {
      const float a =
          2 * kPi * (static_cast<float>(k) + Draw(rng_, -0.1, 0.1)) / static_cast<float>(limb.ribs);
      const Vec3f out = std::cos(a) * x + std::sin(a) * y;
      if (at.z() + radius * out.z() < 0.05f) continue;
      spines_.Add(templates_[static_cast<size_t>(rng_.UniformInt(0, 2))],
                  {at + 0.96f * radius * out, out + 0.2f * along, along,
                   limb.spine_m * Draw(rng_, 0.7, 1.3)});
    }
  }

  Rng rng_;
  Mesh body_;
  SheetGrower spines_;
  std::vector<SheetTemplate> templates_;
};

// Rings along a path whose end is a dome.
std::vector<LimbRing> DomedRings(const Path3& path, const std::function<float(float)>& radius,
                                 float step_m) {
  const Path3 even = Resampled(path, step_m);
  float length = 0;
  for (size_t i = 1; i < even.size(); ++i) length += (even[i] - even[i - 1]).norm();
  std::vector<LimbRing> rings;
  float along = 0;
  const float round = radius(1);
  for (size_t i = 0; i < even.size(); ++i) {
    if (i > 0) along += (even[i] - even[i - 1]).norm();
    if (length - along < round) break;
    rings.push_back({even[i], radius(along / length)});
  }
  const Vec3f top = even.back(), way = (even.back() - even[even.size() - 2]).normalized();
  for (const float s : {0.0f, 0.3f, 0.55f, 0.76f, 0.91f, 0.98f}) {
    const float r = round * std::sqrt(1 - s * s);
    rings.push_back({top - (1 - s) * round * way, std::max(0.04f * round, r)});
  }
  rings.push_back({top, 0.01f * round});
  return rings;
}

float StepOf(float radius) { return radius * ByDetail<float>({0.7f, 1.0f, 1.6f, 2.5f}); }

// A tall ribbed cactus with arms (saguaro).
struct ColumnCactusParams {
  float height_m = 3, radius_m = 0.16f;
  int ribs = 14;
  int arms = 2;
  uint64_t seed = 0;
};

Asset MakeColumnCactus(const ColumnCactusParams& p) {
  CactusGrower grower(p.seed);
  Rng& rng = grower.rng();
  const float h = p.height_m, r = p.radius_m;
  const auto bulge = [r](float s) {
    return r * (0.8f + 0.2f * Smooth01(s / 0.3f) - 0.12f * s * s);
  };
  const Vec3f lean{Draw(rng, -0.04, 0.04), Draw(rng, -0.04, 0.04), 0};
  CactusLimb trunk{.ribs = p.ribs};
  Path3 axis;
  for (int k = 0; k <= 8; ++k) {
    const float s = static_cast<float>(k) / 8;
    axis.push_back(Vec3f(0, 0, s * h) + s * s * h * lean);
  }
  trunk.rings = DomedRings(Spline(axis, 3), bulge, StepOf(r));
  grower.Add(trunk);
  for (int k = 0; k < p.arms; ++k) {
    const float a = Draw(rng, 0, 2 * kPi), z = h * Draw(rng, 0.32, 0.6);
    const Vec3f out(std::cos(a), std::sin(a), 0), from(0, 0, z);
    const float reach = r * Draw(rng, 2.0, 3.2), up = (h - z) * Draw(rng, 0.35, 0.95);
    const float own = r * Draw(rng, 0.55, 0.75);
    CactusLimb arm{.ribs = std::max(8, p.ribs - 3)};
    const Path3 path =
        Spline(Path3{from, from + 0.7f * reach * out + Vec3f(0, 0, 0.05f * reach),
                     from + reach * out + Vec3f(0, 0, 0.55f * reach),
                     from + 1.04f * reach * out + Vec3f(0, 0, 0.55f * reach + 0.5f * up),
                     from + Draw(rng, 0.98, 1.12) * reach * out + Vec3f(0, 0, 0.55f * reach + up)},
               6);
    arm.rings = DomedRings(
        path, [own](float s) { return own * (0.72f + 0.28f * Smooth01(s / 0.45f)); }, StepOf(own));
    grower.Add(arm);
  }
  return grower.Finish(p.seed);
}

// Round ribbed cacti.
struct BarrelCactusParams {
  float radius_m = 0.22f;
  float tall = 1;  // Height over width.
  int ribs = 18;
  int heads = 1;
  uint64_t seed = 0;
};

Asset MakeBarrelCactus(const BarrelCactusParams& p) {
  CactusGrower grower(p.seed);
  Rng& rng = grower.rng();
  for (int k = 0; k < p.heads; ++k) {
    const float size = p.radius_m * (k == 0 ? 1.0f : Draw(rng, 0.4, 0.75));
    const float a = 2.39996f * static_cast<float>(k), away = k == 0 ? 0.0f : 1.25f * p.radius_m;
    const Vec3f foot(away * std::cos(a), away * std::sin(a), 0);
    CactusLimb ball{
        .ribs = p.ribs, .depth = 0.2f, .cushion_m = 0.16f * size, .spine_m = 0.3f * size};
    constexpr int kRings = 16;
    for (int i = 0; i <= kRings; ++i) {
      const float s = static_cast<float>(i) / kRings, t = 2 * s - 1;
      const float wide = std::sqrt(std::max(0.0f, 1 - t * t));
      // Pressed in on top, where it grows.
      const float dip = 0.12f * std::max(0.0f, s - 0.93f) / 0.07f;
      ball.rings.push_back(
          {foot + Vec3f(0, 0, size * p.tall * (2 * s - dip)), std::max(0.05f, wide) * size});
    }
    grower.Add(ball);
  }
  return grower.Finish(p.seed);
}

// A cactus of flat pads (opuntia).
struct PricklyPearParams {
  float pad_m = 0.24f;
  int stems = 4;
  int levels = 3;  // Levels of pads, each on the last.
  uint64_t seed = 0;
};

Asset MakePricklyPear(const PricklyPearParams& p) {
  CactusGrower grower(p.seed);
  Rng& rng = grower.rng();
  struct Bud {
    Vec3f at, way;
    int level;
  };
  std::vector<Bud> buds;
  for (int k = 0; k < p.stems; ++k) {
    const float a = 2.39996f * static_cast<float>(k) + Draw(rng, -0.4, 0.4),
                lean = k == 0 ? 0.1f : Draw(rng, 0.5, 1.0);
    const Vec3f out(std::cos(a), std::sin(a), 0);
    buds.push_back({0.5f * p.pad_m * (k == 0 ? 0.0f : 1.0f) * out,
                    (Vec3f::UnitZ() + lean * out).normalized(), 0});
  }
  for (size_t i = 0; i < buds.size(); ++i) {
    const Bud bud = buds[i];
    const float length = p.pad_m * Draw(rng, 0.75, 1.15) * (bud.level == 0 ? 1.15f : 1.0f);
    grower.AddPad(bud.at - 0.06f * length * bud.way, bud.way, Draw(rng, 0, 2 * kPi), length);
    if (bud.level + 1 >= p.levels) continue;
    const int children = rng.UniformInt(1, 2) + (bud.level == 0 ? 1 : 0);
    for (int c = 0; c < children; ++c) {
      const Vec3f shake{Draw(rng, -1, 1), Draw(rng, -1, 1), Draw(rng, -0.2, 0.6)};
      const Vec3f way = (bud.way + 0.75f * shake + Vec3f(0, 0, 0.25f)).stableNormalized();
      buds.push_back(
          {bud.at + 0.84f * length * bud.way + 0.18f * length * shake, way, bud.level + 1});
    }
  }
  return grower.Finish(p.seed);
}

}  // namespace

Asset SampleColumnCactus(Rng& rng) {
  ColumnCactusParams p{.height_m = Draw(rng, 1.2, 5.5)};
  p.radius_m = 0.07f + 0.028f * p.height_m * Draw(rng, 0.8, 1.25);
  p.ribs = rng.UniformInt(11, 18);
  p.arms = p.height_m < 2.2f ? 0 : rng.UniformInt(0, 4);
  p.seed = rng.Seed();
  return MakeColumnCactus(p);
}

Asset SampleBarrelCactus(Rng& rng) {
  return MakeBarrelCactus({.radius_m = Draw(rng, 0.12, 0.34),
                           .tall = Draw(rng, 0.75, 1.5),
                           .ribs = rng.UniformInt(14, 24),
                           .heads = rng.Bernoulli(0.6) ? 1 : rng.UniformInt(2, 4),
                           .seed = rng.Seed()});
}

Asset SamplePricklyPear(Rng& rng) {
  return MakePricklyPear({.pad_m = Draw(rng, 0.16, 0.32),
                          .stems = rng.UniformInt(2, 6),
                          .levels = rng.UniformInt(2, 4),
                          .seed = rng.Seed()});
}

}  // namespace parallax
