// Plants in pots, bushes, cactuses, and small finds from walks.
#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"
#include "worker/assets/plants/plant_growth.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// The outside of a pot, from the middle of its underside to the rim.
Path2 PotWall(int form, float r, float h) {
  Path2 wall;
  switch (form) {
    case 0:  // Flower pot with a rim.
      wall = Filleted(
          Path2{{0.55f * r, 0}, {0.7f * r, 0}, {0.9f * r, 0.8f * h}, {r, 0.8f * h}, {1.02f * r, h}},
          0.004f, 3);
      break;
    case 1:
      wall = Spline(Path2{{0.5f * r, 0},
                          {0.6f * r, 0.02f * h},
                          {0.95f * r, 0.35f * h},
                          {1.02f * r, 0.7f * h},
                          {0.95f * r, h}},
                    6);
      break;
    case 2:
      wall = Filleted(Path2{{0.6f * r, 0}, {0.96f * r, 0}, {r, 0.5f * h}, {r, h}}, 0.01f, 4);
      break;
    default:
      wall =
          Filleted(Path2{{0.5f * r, 0}, {0.72f * r, 0}, {0.86f * r, 0.5f * h}, {r, h}}, 0.006f, 3);
  }
  wall.insert(wall.begin(), Vec2f(0, 0));
  return wall;
}

// The habit of a potted plant.
enum class PlantKind { kBlades, kRosette, kBroad, kFern, kSnake, kCactus, kPalm, kTree, kCount };

// A plant in a pot, with its soil.
struct PotPlantParams {
  PlantKind kind = PlantKind::kBroad;
  float pot_radius_m = 0.07f;
  float pot_height_m = 0.12f;
  float plant_m = 0.25f;  // Height above the soil, roughly.
  bool saucer = true;
  uint64_t seed = 0;
};

// The pot itself, `lift` above the ground, some with ribs, and its saucer.
void AddVessel(AssetBuilder& b, const PotPlantParams& p, const Path2& wall, float lift, Rng& rng) {
  const float r = p.pot_radius_m, h = p.pot_height_m;
  const MaterialSlot slot = Slot("pot", {"ceramic", "stone", "plastic"});
  LatheOptions options{.segments = 64};
  const int ribs = rng.Bernoulli(0.3) ? rng.UniformInt(14, 28) : 0;
  if (ribs > 0)
    options.modulate = [=](float a, float z) {
      return 1 + 0.018f * Smooth01(z / h * 6) * Smooth01((1 - z / h) * 6) *
                     std::cos(static_cast<float>(ribs) * a);
    };
  b.Add(Lathe(VesselProfile(wall, 0.06f * r + 0.001f, 0.08f * h), options).Moved(0, 0, lift), slot);
  if (!p.saucer) return;
  const float sr = wall[2].x() * 1.25f + 0.01f;
  b.Add(Lathe(VesselProfile(Filleted(Path2{{0, 0}, {sr, 0}, {sr * 1.08f, 0.13f * h}}, 0.006f, 3),
                            0.0035f, 0.0055f)),
        slot);
}

// Radius of the soil: the wall's at 0.86 of the height, less its thickness.
float SoilRadius(const Path2& wall, float r, float h) {
  float sr = r;
  for (size_t i = 1; i < wall.size(); ++i) {
    if (wall[i].y() >= 0.86f * h) {
      sr = wall[i - 1].x() + (wall[i].x() - wall[i - 1].x()) *
                                 std::clamp((0.86f * h - wall[i - 1].y()) /
                                                std::max(1e-5f, wall[i].y() - wall[i - 1].y()),
                                            0.0f, 1.0f);
      break;
    }
  }
  return sr - 0.03f * r;
}

// A lumpy disc with its surface at `top`, a little below the rim, and stones on it.
void AddSoil(AssetBuilder& b, const PotPlantParams& p, float sr, float top, Rng& rng) {
  const float r = p.pot_radius_m, h = p.pot_height_m;
  const Noise noise(rng);
  Path2 disc{{0, top - 0.12f * h}, {0.93f * sr, top - 0.12f * h}};
  for (int k = 10; k >= 0; --k)
    disc.emplace_back(sr * static_cast<float>(k) / 10.0f,
                      top + 0.012f * (1 - static_cast<float>(k * k) / 100.0f));
  Shape soil = Lathe(disc, {.segments = 48}).Bent([&](const Vec3f& q) {
    const float z =
        q.z() > top - 0.02f ? q.z() + 0.05f * r * noise.Fractal(q * (1.6f / r), 3) : q.z();
    return Vec3f(q.x(), q.y(), z);
  });
  b.Add(soil, Slot("soil", {"soil", "sand"}));
  for (int i = 0; i < 14; ++i) {
    const float a = Draw(rng, 0, 2 * kPi), d = 0.86f * sr * std::sqrt(Draw(rng, 0, 1)),
                s = r * Draw(rng, 0.03, 0.075);
    const Noise own(rng);
    b.Add(Ellipsoid({s, s * 0.8f, s * 0.6f}, 12)
              .Bent([&](const Vec3f& q) { return Vec3f(q * (1 + 0.35f * own.At(q / s))); })
              .TurnedZ(Draw(rng, 0, 6))
              .Moved(d * std::cos(a), d * std::sin(a), top + 0.01f),
          Slot("soil", {"soil", "sand"}));
  }
}

void AddPot(AssetBuilder& b, const PotPlantParams& p, Rng& rng) {
  const float r = p.pot_radius_m, h = p.pot_height_m, lift = p.saucer ? 0.006f : 0.0f;
  const Path2 wall = PotWall(rng.UniformInt(0, 3), r, h);
  AddVessel(b, p, wall, lift, rng);
  AddSoil(b, p, SoilRadius(wall, r, h), 0.88f * h + lift, rng);
}

void AddPottedCactus(AssetBuilder& b, const PotPlantParams& p, float z, Rng& rng) {
  const float r = 0.62f * p.pot_radius_m, h = std::max(p.plant_m, 2.2f * r);
  Path3 axis;
  for (int k = 0; k <= 6; ++k)
    axis.emplace_back(0.03f * h * std::sin(0.6f * static_cast<float>(k)), 0,
                      h * static_cast<float>(k) / 6.0f - 0.4f * r);
  GrowCactus(b, {{0, 0, z}, axis, r, rng.UniformInt(9, 14), 0.18f * r + 0.004f}, rng);
}

// A ringed trunk from the soil at height `z`, and fronds from its top: grown about the origin's
// axis, then carried over.
void AddPalm(AssetBuilder& b, const PotPlantParams& p, float z, int stem, int stems, Rng& rng) {
  const float trunk = 0.45f * p.plant_m;
  const float a = Golden(stem), lean = stems > 1 ? 0.25f : 0.06f;
  const Vec3f top(lean * trunk * std::cos(a), lean * trunk * std::sin(a),
                  z + trunk * Draw(rng, 0.8, 1.1));
  Path3 path;
  const Vec3f from(0.25f * top.x(), 0.25f * top.y(), z - 0.02f);
  for (int k = 0; k <= 24; ++k)
    path.push_back(from + (top - from) * (static_cast<float>(k) / 24.0f));
  const SweepOptions rings{.scale = [](float t) {
    return Vec2f::Constant((1.0f - 0.35f * t) * (1 + 0.07f * std::sin(150 * t))).eval();
  }};
  b.Add(Sweep(path, EllipseSection(0.06f * p.plant_m, 0.06f * p.plant_m, 12), rings),
        Slot("trunk", {"bark", "wood"}));
  AssetBuilder crown(p.seed + static_cast<uint64_t>(stem) + 1);
  GrowFern(crown, 0, 0.55f * p.plant_m, true, rng);
  const Asset part = crown.Finish();
  Eigen::Affine3f carry = Eigen::Affine3f::Identity();
  const Box3f box = part.mesh.Bounds();
  carry.translate(Vec3f(top.x() - box.center().x(), top.y() - box.center().y(),
                        top.z() - 0.08f * p.plant_m - 0.12f * box.sizes().z()));
  b.AddMesh(part.mesh, carry);
}

Asset MakePotPlant(const PotPlantParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "plant");
  AddPot(b, p, rng);
  const float z = 0.88f * p.pot_height_m + (p.saucer ? 0.006f : 0.0f) + 0.004f;
  const float spread = 0.4f * p.pot_radius_m;
  switch (p.kind) {
    case PlantKind::kBlades:
      GrowBlades(b, z, p.plant_m, spread, rng);
      break;
    case PlantKind::kRosette:
      GrowRosette(b, z, 0.85f * p.plant_m, rng);
      break;
    case PlantKind::kFern:
      GrowFern(b, z, p.plant_m, false, rng);
      break;
    case PlantKind::kSnake:
      GrowSnake(b, z, p.plant_m, 1.4f * spread, rng);
      break;
    case PlantKind::kCactus:
      AddPottedCactus(b, p, z, rng);
      break;
    case PlantKind::kPalm: {
      const int stems = rng.UniformInt(1, 3);
      for (int s = 0; s < stems; ++s) AddPalm(b, p, z, s, stems, rng);
      break;
    }
    case PlantKind::kTree: {
      TreeGrower tree{b, rng, 0.085f * p.plant_m + 0.02f, 3};
      tree.Branch({0, 0, z - 0.02f}, Vec3f::UnitZ(), 0.42f * p.plant_m, 0.018f * p.plant_m + 0.004f,
                  0);
      tree.Finish();
      break;
    }
    default:
      GrowBroad(b, z, p.plant_m, spread, p.seed % 3 == 0, rng);
  }
  return b.Finish();
}

// A bush without a pot.
struct BushParams {
  float size_m = 0.8f;       // Height, roughly.
  float leaf_width = 0.45f;  // In lengths.
  int stems = 12;
  uint64_t seed = 0;
};

Asset MakeBush(const BushParams& p) {
  const float size = p.size_m;
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "growth");
  TreeGrower bush{b, rng, 0.075f * size + 0.012f, 2};
  bush.leaf_width = p.leaf_width;
  bush.leaves_per_twig = 15;
  const int stems = p.stems;
  for (int i = 0; i < stems; ++i) {
    const float a = Golden(i), t = std::sqrt(static_cast<float>(i) / static_cast<float>(stems));
    const Vec3f heading(t * 0.95f * std::cos(a), t * 0.95f * std::sin(a), 1.2f - 0.6f * t);
    bush.Branch({0.05f * size * t * std::cos(a), 0.05f * size * t * std::sin(a), 0}, heading,
                0.36f * size, 0.009f * size, 0);
  }
  bush.Finish();
  return b.Finish();
}

// A ribbed cactus with arms.
struct CactusParams {
  float height_m = 0.9f, radius_m = 0.08f;
  int ribs = 12, arms = 2;
  uint64_t seed = 0;
};

Asset MakeCactus(const CactusParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "growth");
  const float h = p.height_m, r = p.radius_m;
  const int ribs = p.ribs;
  Path3 axis;
  for (int k = 0; k <= 10; ++k)
    axis.emplace_back(0.01f * h * std::sin(0.5f * static_cast<float>(k)), 0,
                      h * static_cast<float>(k) / 10.0f);
  GrowCactus(b, {Vec3f::Zero(), axis, r, ribs, 0.3f * r}, rng);
  const int arms = p.arms;
  for (int i = 0; i < arms; ++i) {
    const float a =
        2 * kPi * static_cast<float>(i) / static_cast<float>(arms) + Draw(rng, -0.4, 0.4);
    const Vec3f out(std::cos(a), std::sin(a), 0);
    const float z = h * Draw(rng, 0.3, 0.55), reach = r * Draw(rng, 2.3, 3.0),
                up = h * Draw(rng, 0.2, 0.36), s = 0.62f * r;
    const Path3 arm =
        Filleted(Path3{0.2f * r * out + Vec3f(0, 0, z), reach * out + Vec3f(0, 0, z + 0.2f * r),
                       reach * out + Vec3f(0, 0, z + up)},
                 1.3f * r, 8);
    GrowCactus(b, {Vec3f::Zero(), Resampled(arm, 0.4f * r), s, ribs - 2, 0.3f * r}, rng);
  }
  return b.Finish();
}

// A sea urchin's shell with spines.
struct UrchinParams {
  float radius_m = 0.028f;  // Radius of the body.
  float spine_m = 0.045f;   // The longest.
  uint64_t seed = 0;
};

Asset MakeUrchin(const UrchinParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "spines");
  const float r = p.radius_m, spine = p.spine_m;
  const Noise noise(rng);
  const Shape body = Ellipsoid({r, r, 0.78f * r}, 40).Bent([&](const Vec3f& q) {
    const float a = std::atan2(q.y(), q.x());
    return Vec3f(q * (1 + 0.025f * std::cos(10 * a) + 0.01f * noise.At(q * 220)));
  });
  b.Add(body, Slot("body", {"leaf", "stone", "ceramic"}));
  Shape spines;
  const int count = 420;
  for (int i = 0; i < count; ++i) {
    const float z = 1 - 2 * (static_cast<float>(i) + 0.5f) / count, s = std::sqrt(1 - z * z),
                a = Golden(i);
    const Vec3f at(r * s * std::cos(a), r * s * std::sin(a), 0.78f * r * z);
    Vec3f out = (at.cwiseQuotient(Vec3f(1, 1, 0.78f)).normalized() +
                 0.16f * Vec3f{Draw(rng, -1, 1), Draw(rng, -1, 1), Draw(rng, -1, 1)})
                    .normalized();
    const float length = spine * Draw(rng, 0.6, 1.0) * (z < -0.6f ? 0.45f : 1.0f);
    spines.Add(
        Tube({at - 0.002f * out, at + length * out}, 0.0011f, 0.0f, 6).Bent([&](const Vec3f& q) {
          // Taper to the tip.
          const float t = std::clamp((q - at).dot(out) / length, 0.0f, 1.0f);
          const Vec3f middle = at + (q - at).dot(out) * out;
          return Vec3f(middle + (q - middle) * (1 - 0.85f * t));
        }));
  }
  b.Add(spines, Slot("spines", {"leaf", "wood", "plastic"}));
  return b.Finish();
}

}  // namespace

Asset SamplePlantContainer(Rng& rng) {
  PotPlantParams p;
  const PlantKind kinds[] = {PlantKind::kBlades, PlantKind::kRosette, PlantKind::kBroad,
                             PlantKind::kFern,   PlantKind::kSnake,   PlantKind::kCactus};
  p.kind = kinds[rng.UniformInt(0, 5)];
  p.pot_radius_m = Draw(rng, 0.05, 0.09);
  p.pot_height_m = p.pot_radius_m * Draw(rng, 1.3, 2.0);
  p.plant_m = p.pot_radius_m * Draw(rng, 2.0, 3.4);
  p.saucer = rng.Bernoulli(0.5);
  p.seed = rng.Seed();
  return MakePotPlant(p);
}

Asset SampleLargePlantContainer(Rng& rng) {
  PotPlantParams p;
  const PlantKind kinds[] = {PlantKind::kBroad, PlantKind::kSnake, PlantKind::kPalm,
                             PlantKind::kTree,  PlantKind::kFern,  PlantKind::kRosette};
  p.kind = kinds[rng.UniformInt(0, 5)];
  p.pot_radius_m = Draw(rng, 0.14, 0.22);
  p.pot_height_m = p.pot_radius_m * Draw(rng, 1.4, 2.2);
  p.plant_m = Draw(rng, 0.7, 1.2);
  if (p.kind == PlantKind::kRosette || p.kind == PlantKind::kFern) p.plant_m = Draw(rng, 0.45, 0.7);
  if (p.kind == PlantKind::kBroad) p.plant_m = Draw(rng, 0.55, 0.85);
  p.saucer = rng.Bernoulli(0.3);
  p.seed = rng.Seed();
  return MakePotPlant(p);
}

Asset SampleBush(Rng& rng) {
  return MakeBush({.size_m = Draw(rng, 0.5, 1.0),
                   .leaf_width = Draw(rng, 0.3, 0.6),
                   .stems = rng.UniformInt(10, 14),
                   .seed = rng.Seed()});
}

Asset SampleCactus(Rng& rng) {
  CactusParams p{.height_m = Draw(rng, 0.5, 1.4)};
  p.radius_m = p.height_m * Draw(rng, 0.075, 0.1);
  p.ribs = rng.UniformInt(10, 15);
  p.arms = rng.UniformInt(1, 4);
  p.seed = rng.Seed();
  return MakeCactus(p);
}

Asset SampleUrchin(Rng& rng) {
  UrchinParams p{.radius_m = Draw(rng, 0.022, 0.035)};
  p.spine_m = p.radius_m * Draw(rng, 1.1, 2.2);
  p.seed = rng.Seed();
  return MakeUrchin(p);
}

}  // namespace parallax
