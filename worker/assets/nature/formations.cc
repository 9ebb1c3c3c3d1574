// Formations of rock: arches, pillars, dripstone of caves.
#include <algorithm>
#include <cmath>
#include <vector>

#include "worker/assets/kernel/detail.h"
#include "worker/assets/nature/detail.h"
#include "worker/assets/nature/ground.h"
#include "worker/assets/nature/limb.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// The cross-section of bedded rock: joints that stand upright cut it to a polygon, and from each
// bed blocks have fallen down to other joints.
class BeddedSection {
 public:
  BeddedSection(float height_m, float bed_m, Rng& rng) : bed_m_(bed_m), noise_(rng) {
    const int sides = rng.UniformInt(6, 9);
    for (int side = 0; side < sides; ++side) {
      const float at = static_cast<float>(side) + Draw(rng, -0.3, 0.3);
      joints_.push_back(at * 2 * kPi / static_cast<float>(sides));
    }
    const int beds = static_cast<int>(height_m / bed_m) + 5;
    for (int bed = 0; bed < beds; ++bed) AddBed(static_cast<float>(bed));
  }

  // Factor on the radius, about 1.
  float At(float angle_rad, float height_m) const {
    const float height = height_m / bed_m_;
    const Vec3f round(std::cos(angle_rad), std::sin(angle_rad), 0.4f * height);
    const float level =
        height + 0.22f * noise_.At(0.9f * round) + 0.5f * noise_.At({0.5f, 0.37f * height, 0.5f});
    // The first bed begins below the foot.
    const float at = std::clamp(level + 2, 0.0f, static_cast<float>(beds_.size()) - 1.01f);
    const float bed = std::floor(at);
    const auto i = static_cast<size_t>(bed);
    const float below = Section(angle_rad, beds_[i]), above = Section(angle_rad, beds_[i + 1]);
    return Lerp(below, above, Smooth01((at - bed - 0.7f) / 0.3f));
  }

 private:
  void AddBed(float bed) {
    const float hard = noise_.At({0.5f, 0.5f, 1.7f * bed + 0.5f});
    std::vector<float>& distances = beds_.emplace_back();
    for (size_t side = 0; side < joints_.size(); ++side) {
      // Few blocks are missing over several beds, many in one.
      const float at = 1.3f * (static_cast<float>(side) + 1.5f);
      const float fallen = 0.2f * noise_.At({at, 0.5f, 0.31f * bed}) +
                           0.13f * noise_.At({at, 7.5f, 1.7f * bed + 0.5f});
      distances.push_back(0.92f + 0.13f * hard + fallen);
    }
  }
  // Distance of the polygon's edge. The soft minimum over its sides rounds corners off.
  float Section(float angle_rad, const std::vector<float>& distances) const {
    float sum = 0;
    for (size_t side = 0; side < joints_.size(); ++side) {
      const float facing = std::cos(angle_rad - joints_[side]);
      if (facing < 0.05f) continue;
      const float x = facing / distances[side], x2 = x * x, x4 = x2 * x2;
      sum += x4 * x4 * x4 * x2;
    }
    return sum > 0 ? std::pow(sum, -1.0f / 14) : 1;
  }

  float bed_m_;
  Noise noise_;
  std::vector<float> joints_;             // The angle that each joint faces.
  std::vector<std::vector<float>> beds_;  // The distance of each joint in each bed, in radii.
};

// Wear at every size down to the mesh's cells, along the surface's normal.
class Weather {
 public:
  Weather(float size_m, Rng& rng) : size_m_(size_m), noise_(rng) {}

  Vec3f Worn(const Vec3f& p, const Vec3f& normal) const {
    const float dents = 0.1f * noise_.Fractal(0.8f * p / size_m_, 5) - 0.05f * Joint(p);
    return p + size_m_ * dents * normal;
  }

 private:
  // Upright cracks; 1 within.
  float Joint(const Vec3f& p) const {
    const Vec3f q(p.x(), p.y(), 0.25f * p.z());
    const float n = std::abs(noise_.At(1.1f * q / size_m_));
    return std::exp(-n * n / (2 * 0.05f * 0.05f));
  }

  float size_m_;
  Noise noise_;
};

// A smaller ring before the first: no sharp rim, whose normals would look two ways at once.
std::vector<LimbRing> WithRoundFoot(std::vector<LimbRing> rings) {
  const Vec3f back = (rings[0].at - rings[1].at).normalized();
  rings.insert(rings.begin(),
               {rings[0].at + 0.06f * rings[0].radius * back, 0.9f * rings[0].radius});
  return rings;
}

// Returns the length of the line from the first ring to each ring.
std::vector<float> WaysAlong(const std::vector<LimbRing>& rings) {
  std::vector<float> ways_m = {0};
  for (size_t i = 1; i < rings.size(); ++i) {
    ways_m.push_back(ways_m.back() + (rings[i].at - rings[i - 1].at).norm());
  }
  return ways_m;
}

// A closed tube of rock along `rings`, worn; texture = place in metres, moved.
Mesh RockTube(const std::vector<LimbRing>& rings, int sides, const BeddedSection& section,
              const Weather& weather, Rng& rng) {
  Mesh mesh;
  mesh.slots.push_back(Slot("stone", {"Sandstone", "Rock"}));
  const std::vector<LimbRing> line = WithRoundFoot(rings);
  LimbOptions options;
  options.sides = sides;
  const std::vector<float> ways_m = WaysAlong(line);
  options.modulate = [&](float angle_rad, float along_m) {
    const auto ring = std::lower_bound(ways_m.begin(), ways_m.end() - 1, along_m - 1e-4f);
    return section.At(angle_rad, line[static_cast<size_t>(ring - ways_m.begin())].at.z());
  };
  AddLimb(mesh, line, options);
  const Vec3f offset{Draw(rng, -20, 20), Draw(rng, -20, 20), Draw(rng, -20, 20)};
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    mesh.positions[i] = weather.Worn(mesh.positions[i], mesh.normals[i]);
    mesh.texture[i] = mesh.positions[i] + offset;
  }
  SetNormals(mesh, 0, 0);
  return mesh;
}

// How long the tube's cells are at the level of detail.
float CellOf(float usual_m) { return std::max(usual_m, 0.9f * TargetEdge()); }

Asset FinishedRock(const Mesh& mesh, uint64_t seed, Anchor anchor = Anchor::kGround) {
  AssetBuilder b(seed);
  b.AddMesh(mesh, Eigen::Affine3f::Identity());
  return b.Finish(anchor);
}

}  // namespace

Asset MakeRockArch(const RockArchParams& p) {
  Rng rng(SceneSeed{p.seed}, "arch");
  const BeddedSection section(p.rise_m, p.bed_m, rng);
  const Weather weather(p.thick_m, rng);
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
  const float cell = CellOf(0.085f * p.thick_m + 0.03f);
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
  const int sides = std::clamp(static_cast<int>(2 * kPi * p.thick_m / cell), 8, 76);
  return FinishedRock(RockTube(rings, sides, section, weather, rng), p.seed);
}

Asset SampleRockArch(Rng& rng) {
  RockArchParams p;
  p.span_m = Draw(rng, 6, 12);
  p.rise_m = p.span_m * Draw(rng, 0.5, 0.95);
  p.thick_m = p.span_m * Draw(rng, 0.13, 0.22);
  p.bed_m = Draw(rng, 0.5, 1.2);
  p.seed = rng.Seed();
  return MakeRockArch(p);
}

Asset MakeRockPillar(const RockPillarParams& p) {
  Rng rng(SceneSeed{p.seed}, "pillar");
  const BeddedSection section(p.height_m, p.bed_m, rng);
  const Weather weather(0.8f * p.radius_m, rng);
  const float cell = CellOf(0.05f * p.radius_m + 0.03f), h = p.height_m;
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
  const int sides = std::clamp(static_cast<int>(2 * kPi * p.radius_m / cell), 10, 110);
  return FinishedRock(RockTube(rings, sides, section, weather, rng), p.seed);
}

Asset SampleRockPillar(Rng& rng) {
  RockPillarParams p;
  p.height_m = Draw(rng, 5, 14);
  p.radius_m = p.height_m * Draw(rng, 0.12, 0.24);
  p.cap = rng.Bernoulli(0.4) ? Draw(rng, 0.12, 0.32) : 0;
  p.bed_m = Draw(rng, 0.5, 1.3);
  p.seed = rng.Seed();
  return MakeRockPillar(p);
}

namespace {

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
  LimbOptions options;
  options.sides = std::clamp(static_cast<int>(2 * kPi * radius / cell), 7, 36);
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

}  // namespace

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

Asset SampleStalactites(Rng& rng) {
  DripstoneParams p;
  p.length_m = Draw(rng, 0.35, 1.7);
  p.radius_m = p.length_m * Draw(rng, 0.07, 0.13);
  p.count = rng.UniformInt(3, 9);
  p.spread_m = Draw(rng, 0.25, 0.8);
  p.seed = rng.Seed();
  return MakeDripstone(p);
}

Asset SampleStalagmites(Rng& rng) {
  DripstoneParams p;
  p.hangs = false;
  p.length_m = Draw(rng, 0.3, 1.5);
  p.radius_m = p.length_m * Draw(rng, 0.12, 0.26);
  p.count = rng.UniformInt(1, 5);
  p.spread_m = Draw(rng, 0.4, 1.0);
  p.seed = rng.Seed();
  return MakeDripstone(p);
}

Asset SampleDripstoneColumn(Rng& rng) {
  DripstoneParams p;
  p.hangs = false;
  p.column = true;
  p.length_m = Draw(rng, 5, 8);
  p.radius_m = Draw(rng, 0.28, 0.65);
  p.count = rng.UniformInt(1, 4);
  p.spread_m = Draw(rng, 0.6, 1.1);
  p.seed = rng.Seed();
  return MakeDripstone(p);
}

}  // namespace parallax
