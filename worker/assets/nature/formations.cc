// Formations of rock: arches, pillars, dripstone of caves.
#include <algorithm>
#include <cmath>
#include <vector>

#include "worker/assets/kernel/detail_scope.h"
#include "worker/assets/nature/bedded_rock.h"
#include "worker/assets/nature/ground_cover.h"
#include "worker/assets/nature/limb.h"
#include "worker/assets/nature/plant_detail.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A smaller ring before the first: no sharp rim, whose normals would look two ways at once.
std::vector<LimbRing> WithRoundFoot(std::vector<LimbRing> rings) {
  const Vec3f back = (rings[0].at - rings[1].at).normalized();
  rings.insert(rings.begin(),
               {rings[0].at + 0.06f * rings[0].radius * back, 0.9f * rings[0].radius});
  return rings;
}

// Adds a smaller ring after the last one, for the same reason, and a flat tip.
void AddRoundEnd(std::vector<LimbRing>& rings) {
  const LimbRing last = rings.back();
  const Vec3f on = (last.at - rings[rings.size() - 2].at).normalized();
  rings.push_back({last.at + 0.06f * last.radius * on, 0.9f * last.radius});
  rings.push_back({last.at + 0.07f * last.radius * on, 0});
}

// The cross-section that upright joints cut: a polygon whose corners are a bit worn.
class JointedSection {
 public:
  explicit JointedSection(Rng& rng) {
    const int sides = rng.UniformInt(5, 8);
    for (int side = 0; side < sides; ++side) {
      const float at = static_cast<float>(side) + Draw(rng, -0.3, 0.3);
      joints_.push_back({at * 2 * kPi / static_cast<float>(sides), Draw(rng, 0.8, 1.05)});
    }
  }

  // Factor on the radius, about 1. The soft minimum over the sides rounds corners off.
  float At(float angle_rad) const {
    float sum = 0;
    for (const Joint& joint : joints_) {
      const float facing = std::cos(angle_rad - joint.faces_rad);
      if (facing > 0.05f) sum += std::pow(facing / joint.distance, 24.0f);
    }
    return sum > 0 ? std::pow(sum, -1.0f / 24) : 1;
  }

 private:
  struct Joint {
    float faces_rad, distance;  // In radii.
  };
  std::vector<Joint> joints_;
};

// A closed tube of rock along `rings`, worn; texture = place in metres, moved.
Mesh RockTube(const std::vector<LimbRing>& rings, int sides, const BeddedRock& rock, Rng& rng) {
  Mesh mesh;
  mesh.slots.push_back(Slot("stone", {"Sandstone", "Rock"}));
  const std::vector<LimbRing> line = WithRoundFoot(rings);
  LimbOptions options{.sides = sides};
  // The rock wears along a round tube's normals: a polygon's would fold its corners over.
  Mesh round;
  AddLimb(round, line, options);
  const JointedSection section(rng);
  options.modulate = [&](float angle_rad, float) { return section.At(angle_rad); };
  AddLimb(mesh, line, options);
  const Vec3f offset{Draw(rng, -20, 20), Draw(rng, -20, 20), Draw(rng, -20, 20)};
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    mesh.positions[i] = rock.Worn(mesh.positions[i], round.normals[i]);
    mesh.texture[i] = mesh.positions[i] + offset;
  }
  SetNormals(mesh, 0, 0);
  return mesh;
}

// A ledge falls off over more than a cell, or its edge is a saw.
constexpr float kLedgeCells = 1.7f;

// How long the tube's cells are at the level of detail.
float CellOf(float usual_m) { return std::max(usual_m, 0.9f * TargetEdge()); }

Asset FinishedRock(const Mesh& mesh, uint64_t seed, Anchor anchor = Anchor::kGround) {
  AssetBuilder b(seed);
  b.AddMesh(mesh, Eigen::Affine3f::Identity());
  return b.Finish(anchor);
}

// A natural arch of bedded rock.
struct RockArchParams {
  float span_m = 9, rise_m = 6;
  float thick_m = 1.6f;  // Radius of its rock.
  float bed_m = 0.9f;    // Thickness of its beds.
  uint64_t seed = 0;
};

// An arch along x whose feet reach into the ground.
Asset MakeRockArch(const RockArchParams& p) {
  Rng rng(SceneSeed{p.seed}, "arch");
  const float cell = CellOf(0.062f * p.thick_m + 0.03f);
  const BeddedRock rock({p.rise_m, p.thick_m, p.bed_m, kLedgeCells * cell}, rng);
  Path3 path;
  const float lean = Draw(rng, -0.12, 0.12), skew = Draw(rng, -0.15, 0.15);
  const float square = Draw(rng, 0.5, 0.75);
  const Noise uneven(rng);
  for (int k = 0; k <= 12; ++k) {
    const float a = kPi * static_cast<float>(k) / 12;
    const float x = -0.5f * p.span_m * std::cos(a);
    path.push_back({x, skew * x + lean * p.rise_m * std::sin(a),
                    p.rise_m * std::pow(std::max(0.0f, std::sin(a)), square)});
  }
  const Path3 even = Resampled(Spline(path, 6), cell);
  std::vector<LimbRing> rings;
  for (size_t i = 0; i < even.size(); ++i) {
    const float s = static_cast<float>(i) / static_cast<float>(even.size() - 1);
    // Thick feet, one thicker than the other; thinnest beside the crown.
    const float feet =
        std::pow(std::abs(2 * s - 1), 2.2f) * (1 + 0.35f * skew / 0.15f * (s - 0.5f));
    const float thick = 0.72f + 0.6f * feet + 0.3f * uneven.At({4 * s, 0.5f, 0.5f});
    rings.push_back({even[i], p.thick_m * thick});
  }
  AddRoundEnd(rings);
  const int sides = std::clamp(static_cast<int>(2 * kPi * p.thick_m / cell), 8, 110);
  return FinishedRock(RockTube(rings, sides, rock, rng), p.seed);
}

// A free-standing pillar of bedded rock.
struct RockPillarParams {
  float height_m = 10, radius_m = 2;
  float cap = 0;  // How far a hard bed on top stands out, in radii.
  float bed_m = 0.9f;
  uint64_t seed = 0;
};

// A stack that the sea or rain left standing.
Asset MakeRockPillar(const RockPillarParams& p) {
  Rng rng(SceneSeed{p.seed}, "pillar");
  const float cell = CellOf(0.042f * p.radius_m + 0.02f), h = p.height_m;
  const BeddedRock rock({h, p.radius_m, p.bed_m, kLedgeCells * cell}, rng);
  const Vec3f lean{0.06f * h * Draw(rng, -1, 1), 0.06f * h * Draw(rng, -1, 1), 0};
  const int pieces = std::max(6, static_cast<int>(h / cell));
  const float waist = Draw(rng, 0.55, 0.95), bend = Draw(rng, 0, 6.2);
  std::vector<LimbRing> rings;
  for (int k = 0; k <= pieces; ++k) {
    const float s = static_cast<float>(k) / static_cast<float>(pieces);
    const float foot = 0.3f * std::exp(-s * 8.0f), worn = 1 - (1 - waist) * Smooth01(s / 0.8f);
    const float cap = p.cap * Smooth01((s - 0.84f) / 0.04f);
    const float top =
        std::sqrt(std::max(0.0f, 1 - std::pow(std::max(0.0f, (s - 0.93f) / 0.07f), 6.0f)));
    const Vec3f sway(0.25f * p.radius_m * std::sin(4 * s + bend),
                     0.25f * p.radius_m * std::cos(3 * s + bend), 0);
    rings.push_back({Vec3f(0, 0, s * h) + s * lean + sway,
                     std::max(0.03f, p.radius_m * (worn + foot + cap) * top)});
  }
  const int sides = std::clamp(static_cast<int>(2 * kPi * p.radius_m / cell), 10, 180);
  return FinishedRock(RockTube(rings, sides, rock, rng), p.seed);
}

// One drop form from its root on towards `way`: rings of sinter, bulges, a slender end.
void AddDrip(Mesh& mesh, const Vec3f& root, float way, float length, float radius, bool blunt,
             Rng& rng) {
  const Noise noise(rng);
  const float cell = CellOf(0.03f + 0.012f * length);
  const int pieces = std::clamp(static_cast<int>(length / cell), 5, 90);
  std::vector<LimbRing> rings;
  const Vec3f lean{Draw(rng, -0.05, 0.05), Draw(rng, -0.05, 0.05), 0};
  for (int k = 0; k <= pieces; ++k) {
    const float s = static_cast<float>(k) / static_cast<float>(pieces);
    const float taper = blunt ? 0.42f * std::pow(1 - s, 0.35f) + 0.58f * std::pow(1 - s, 1.6f)
                              : std::pow(1 - s, 0.8f);
    // The foot spreads where it joins the rock.
    const float foot = 0.9f * std::exp(-s * length / (0.7f * radius));
    const float rough = 1 + 0.22f * noise.At({0.5f, 0.5f, s * length / (0.9f * radius)}) +
                        0.12f * noise.At({2.5f, 0.5f, s * length / (0.3f * radius)});
    rings.push_back({root + Vec3f(0, 0, way * s * length) + s * length * lean,
                     std::max(0.004f, radius * (taper + foot) * rough)});
  }
  LimbOptions options{.sides = std::clamp(static_cast<int>(2 * kPi * radius / cell), 7, 36)};
  const float flutes = Draw(rng, 3, 6), phase = Draw(rng, 0, 6);
  options.modulate = [=](float angle, float along) {
    return 1 +
           0.09f * std::sin(std::round(flutes) * angle + phase) *
               std::sin(0.8f * along / radius + phase) +
           0.05f * std::sin(2 * std::round(flutes) * angle);
  };
  const size_t first = mesh.positions.size();
  AddLimb(mesh, WithRoundFoot(rings), options);
  const Vec3f offset{Draw(rng, -20, 20), Draw(rng, -20, 20), Draw(rng, -20, 20)};
  for (size_t i = first; i < mesh.positions.size(); ++i)
    mesh.texture[i] = mesh.positions[i] + offset;
}

// Stalactites, stalagmites or columns in a cave.
struct DripstoneParams {
  float length_m = 0.8f, radius_m = 0.09f;
  int count = 5;
  float spread_m = 0.5f;
  bool hangs = true;    // From a roof, else it stands on the floor.
  bool column = false;  // Both grown together.
  uint64_t seed = 0;
};

Asset MakeDripstone(const DripstoneParams& p) {
  Rng rng(SceneSeed{p.seed}, "dripstone");
  Mesh mesh;
  mesh.slots.push_back(Slot("stone", {"CaveRock"}));
  const float way = p.hangs ? -1.0f : 1.0f;
  for (int k = 0; k < p.count; ++k) {
    const float size = k == 0 ? 1.0f : Draw(rng, 0.25, 0.8);
    const float a = 2.39996f * static_cast<float>(k) + Draw(rng, -0.6, 0.6),
                away = k == 0 ? 0.0f : p.spread_m * Draw(rng, 0.3, 1.0);
    const Vec3f root(away * std::cos(a), away * std::sin(a), 0);
    const float radius = p.radius_m * Lerp(1.0f, size, 0.7f);
    if (!p.column || k > 0) {
      AddDrip(mesh, root, way, p.length_m * size * (p.column ? 0.25f : 1.0f), radius, !p.hangs,
              rng);
      continue;
    }
    // Two that met: the lower one's top is in the upper one.
    AddDrip(mesh, root, 1, 0.75f * p.length_m, radius, true, rng);
    AddDrip(mesh, root + Vec3f(0, 0, p.length_m), -1, 0.8f * p.length_m, 0.85f * radius, true, rng);
  }
  return FinishedRock(mesh, p.seed, p.hangs ? Anchor::kCeiling : Anchor::kGround);
}

}  // namespace

Asset SampleRockArch(Rng& rng) {
  RockArchParams p{.span_m = Draw(rng, 6, 12)};
  p.rise_m = p.span_m * Draw(rng, 0.5, 0.95);
  p.thick_m = p.span_m * Draw(rng, 0.13, 0.22);
  p.bed_m = Draw(rng, 0.5, 1.2);
  p.seed = rng.Seed();
  return MakeRockArch(p);
}

Asset SampleRockPillar(Rng& rng) {
  RockPillarParams p{.height_m = Draw(rng, 5, 14)};
  p.radius_m = p.height_m * Draw(rng, 0.12, 0.24);
  p.cap = rng.Bernoulli(0.4) ? Draw(rng, 0.12, 0.32) : 0;
  p.bed_m = Draw(rng, 0.5, 1.3);
  p.seed = rng.Seed();
  return MakeRockPillar(p);
}

Asset SampleStalactites(Rng& rng) {
  DripstoneParams p{.length_m = Draw(rng, 0.35, 1.7)};
  p.radius_m = p.length_m * Draw(rng, 0.07, 0.13);
  p.count = rng.UniformInt(3, 9);
  p.spread_m = Draw(rng, 0.25, 0.8);
  p.seed = rng.Seed();
  return MakeDripstone(p);
}

Asset SampleStalagmites(Rng& rng) {
  DripstoneParams p{.length_m = Draw(rng, 0.3, 1.5), .hangs = false};
  p.radius_m = p.length_m * Draw(rng, 0.12, 0.26);
  p.count = rng.UniformInt(1, 5);
  p.spread_m = Draw(rng, 0.4, 1.0);
  p.seed = rng.Seed();
  return MakeDripstone(p);
}

Asset SampleDripstoneColumn(Rng& rng) {
  return MakeDripstone({.length_m = Draw(rng, 5, 8),
                        .radius_m = Draw(rng, 0.28, 0.65),
                        .count = rng.UniformInt(1, 4),
                        .spread_m = Draw(rng, 0.6, 1.1),
                        .hangs = false,
                        .column = true,
                        .seed = rng.Seed()});
}

}  // namespace parallax
