// Plants: what a level of detail keeps, how wood thins out, what a sheet is.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "worker/assets/kernel/detail_scope.h"
#include "worker/assets/nature/bedded_rock.h"
#include "worker/assets/nature/plant_detail.h"
#include "worker/assets/nature/skeleton.h"
#include "worker/assets/nature/trees.h"

namespace parallax {
namespace {

Mesh TreeAt(PlantDetail detail, bool conifer, size_t species, uint64_t seed) {
  const kernel::DetailScope scope(EdgeOfDetail(detail));
  if (conifer) {
    ConiferParams p;
    p.species = species;
    p.height_m =
        0.5f * (ConiferTable()[species].height_low_m + ConiferTable()[species].height_high_m);
    p.seed = seed;
    return MakeConifer(p).mesh;
  }
  BroadleafParams p;
  p.species = species;
  p.height_m =
      0.5f * (BroadleafTable()[species].height_low_m + BroadleafTable()[species].height_high_m);
  p.seed = seed;
  return MakeBroadleafTree(p).mesh;
}

struct Kind {
  bool conifer;
  size_t species;
};
std::vector<Kind> AllKinds() {
  std::vector<Kind> kinds;
  for (size_t i = 0; i < BroadleafTable().size(); ++i) kinds.push_back({false, i});
  for (size_t i = 0; i < ConiferTable().size(); ++i) kinds.push_back({true, i});
  return kinds;
}
std::string_view NameOf(const Kind& kind) {
  return kind.conifer ? ConiferTable()[kind.species].name : BroadleafTable()[kind.species].name;
}

double SheetArea(const Mesh& mesh) {
  double area = 0;
  for (const Triangle& t : mesh.triangles) {
    if (!mesh.slots[t.slot].sheet) continue;
    area += 0.5 * (mesh.positions[t.b] - mesh.positions[t.a])
                      .cross(mesh.positions[t.c] - mesh.positions[t.a])
                      .cast<double>()
                      .norm();
  }
  return area;
}

// Leaves, needle sprays: each has its own pair in uv.
size_t SheetCount(const Mesh& mesh) {
  std::set<std::pair<float, float>> own;
  for (const Triangle& t : mesh.triangles) {
    if (mesh.slots[t.slot].sheet) own.insert({mesh.uv[t.a].x(), mesh.uv[t.a].y()});
  }
  return own.size();
}

TEST(PlantDetail, EdgesAndLevelsAgree) {
  for (const PlantDetail detail :
       {PlantDetail::kNear, PlantDetail::kMid, PlantDetail::kFar, PlantDetail::kShell}) {
    EXPECT_EQ(DetailOfEdge(EdgeOfDetail(detail)), detail);
    const kernel::DetailScope scope(EdgeOfDetail(detail));
    EXPECT_EQ(CurrentDetail(), detail);
  }
}

TEST(Trees, HaveTheTrianglesThatTheirLevelPromises) {
  struct Range {
    PlantDetail detail;
    size_t least, most;
  };
  for (const Kind& kind : AllKinds()) {
    for (const Range& range :
         {Range{PlantDetail::kNear, 60'000, 150'000}, Range{PlantDetail::kMid, 15'000, 40'000},
          Range{PlantDetail::kFar, 3'000, 8'000}, Range{PlantDetail::kShell, 200, 600}}) {
      const Mesh mesh = TreeAt(range.detail, kind.conifer, kind.species, 3);
      EXPECT_GE(mesh.triangles.size(), range.least)
          << NameOf(kind) << " level " << static_cast<int>(range.detail);
      EXPECT_LE(mesh.triangles.size(), range.most)
          << NameOf(kind) << " level " << static_cast<int>(range.detail);
    }
  }
}

TEST(Trees, HaveThousandsOfLeavesNear) {
  for (const Kind& kind : AllKinds()) {
    // A conifer's sprays and tufts count; each has a dozen needles.
    EXPECT_GE(SheetCount(TreeAt(PlantDetail::kNear, kind.conifer, kind.species, 5)), 5'000u)
        << NameOf(kind);
  }
}

// The area of leaves stays when they are fewer: a crown covers as much of the picture.
TEST(Trees, KeepTheAreaOfTheirLeavesWhenTheyAreThinned) {
  for (const Kind& kind : AllKinds()) {
    if (kind.conifer) continue;
    const double near = SheetArea(TreeAt(PlantDetail::kNear, false, kind.species, 7));
    for (const PlantDetail detail : {PlantDetail::kMid, PlantDetail::kFar, PlantDetail::kShell}) {
      const double there = SheetArea(TreeAt(detail, false, kind.species, 7));
      const double tolerance = detail == PlantDetail::kShell ? 0.25 : 0.1;
      EXPECT_NEAR(there / near, 1, tolerance) << NameOf(kind) << " " << static_cast<int>(detail);
    }
  }
}

TEST(Trees, ShellsAreAsLargeAsTheTree) {
  for (const Kind& kind : AllKinds()) {
    const Vec3f near = TreeAt(PlantDetail::kNear, kind.conifer, kind.species, 9).Bounds().sizes();
    const Vec3f shell = TreeAt(PlantDetail::kShell, kind.conifer, kind.species, 9).Bounds().sizes();
    EXPECT_NEAR(shell.z() / near.z(), 1, 0.15) << NameOf(kind);
    EXPECT_NEAR(shell.head<2>().norm() / near.head<2>().norm(), 1, 0.3) << NameOf(kind);
  }
}

// A fan of points above a stem.
Skeleton Grown(uint64_t seed) {
  Rng rng(SceneSeed{seed}, "points");
  std::vector<Vec3f> points;
  for (int k = 0; k < 300; ++k) {
    points.push_back(
        Vec3d(rng.Uniform(-2, 2), rng.Uniform(-2, 2), rng.Uniform(2, 5)).cast<float>());
  }
  Skeleton tree;
  tree.Add(Vec3f::Zero(), -1);
  tree.Add({0, 0, 1}, 0);
  tree.Colonise(points, {.step_m = 0.15f, .kill_m = 0.3f, .first_node = 1}, rng);
  tree.Thicken(0.2f, 0.01f);
  return tree;
}

TEST(Skeleton, ReachesItsPointsAndNoChildIsThickerThanItsParent) {
  const Skeleton tree = Grown(1);
  ASSERT_GT(tree.nodes().size(), 100u);
  EXPECT_NEAR(tree.nodes()[0].radius, 0.2f, 1e-4f);
  for (const TreeNode& node : tree.nodes()) {
    if (node.parent < 0) continue;
    const TreeNode& parent = tree.nodes()[static_cast<size_t>(node.parent)];
    EXPECT_LE(node.radius, parent.radius + 1e-6f);
    EXPECT_GE(node.radius, 0.01f - 1e-6f);
  }
  Rng rng(SceneSeed{1}, "points");
  for (int k = 0; k < 300; ++k) {
    const Vec3f point =
        Vec3d(rng.Uniform(-2, 2), rng.Uniform(-2, 2), rng.Uniform(2, 5)).cast<float>();
    float nearest = 1e9f;
    for (const TreeNode& node : tree.nodes()) nearest = std::min(nearest, (node.at - point).norm());
    EXPECT_LT(nearest, 0.3f);
  }
}

TEST(Skeleton, EveryNodeBeyondTheFootBelongsToOneLimb) {
  const Skeleton tree = Grown(2);
  std::vector<int> times(tree.nodes().size());
  for (const std::vector<int>& limb : tree.Limbs()) {
    for (size_t i = 1; i < limb.size(); ++i) {
      ++times[static_cast<size_t>(limb[i])];
      EXPECT_EQ(tree.nodes()[static_cast<size_t>(limb[i])].parent, limb[i - 1]);
    }
  }
  for (size_t i = 1; i < times.size(); ++i) EXPECT_EQ(times[i], 1) << i;
}

TEST(Sheets, AreOpenCarryTheirOwnNumbersAndMayNotCoincide) {
  SheetGrower grower({"leaves", {"SummerLeaf"}, false, true}, Rng(SceneSeed{3}));
  const SheetTemplate leaf = MakeLeafTemplate({});
  SheetPlace place;
  place.at.z() = 1;
  grower.Add(leaf, place);
  place.at.x() = 0.3f;
  grower.Add(leaf, place);
  EXPECT_EQ(SheetCount(grower.mesh()), 2u);
  EXPECT_TRUE(ValidateMesh(grower.mesh()).ok()) << ValidateMesh(grower.mesh());
  for (const Vec2f& own : grower.mesh().uv) {
    EXPECT_GE(own.minCoeff(), 0);
    EXPECT_LE(own.maxCoeff(), 1);
  }
  grower.Add(leaf, place);
  EXPECT_EQ(ValidateMesh(grower.mesh()).code(), absl::StatusCode::kInvalidArgument);
  // Two closed bodies may share a face; only sheets may not.
  Mesh solid = grower.mesh();
  solid.slots[0].sheet = false;
  EXPECT_TRUE(ValidateMesh(solid).ok());
}

TEST(Sheets, LieAboutTheirPlaceWithTheUpperSideUp) {
  for (const LeafShape shape :
       {LeafShape::kElliptic, LeafShape::kOvate, LeafShape::kLance, LeafShape::kOblong,
        LeafShape::kLobed, LeafShape::kPalmate, LeafShape::kBlade, LeafShape::kPetal}) {
    const SheetTemplate leaf = MakeLeafTemplate({.shape = shape, .droop = 0.3f});
    EXPECT_GT(leaf.area, 0.05f);
    for (const Vec3f& n : leaf.normals) EXPECT_GT(n.z(), 0.5f) << static_cast<int>(shape);
    float far = 0;
    for (const Vec3f& p : leaf.points) far = std::max(far, p.y());
    EXPECT_NEAR(far, 1, 0.05f) << static_cast<int>(shape);
  }
}

// Returns how far from its axis a round pillar's wall is once it is worn, in metres.
float WornRadius(const BeddedRock& rock, const BeddedRockSpec& spec, float angle, float height_m) {
  const Vec3f normal(std::cos(angle), std::sin(angle), 0);
  return rock.Worn(spec.thick_m * normal + Vec3f(0, 0, height_m), normal).head<2>().norm();
}

TEST(BeddedRock, BlocksStandOutAndFallBetweenLedges) {
  const BeddedRockSpec spec{.height_m = 10, .thick_m = 2, .bed_m = 0.9f, .ledge_m = 0.1f};
  for (uint64_t seed = 0; seed < 8; ++seed) {
    Rng rng(SceneSeed{seed}, "rock");
    const BeddedRock rock(spec, rng);
    int ledges = 0;
    float least = 1e9f, most = 0;
    for (int side = 0; side < 12; ++side) {
      const float angle = 0.5f * static_cast<float>(side);
      for (float z = 0; z < spec.height_m; z += spec.ledge_m) {
        const float here = WornRadius(rock, spec, angle, z);
        const float above = WornRadius(rock, spec, angle, z + 2 * spec.ledge_m);
        ledges += std::abs(above - here) > 0.1f * spec.thick_m;
        least = std::min(least, here);
        most = std::max(most, here);
      }
    }
    // The loops visit 1,200 places; a smooth pillar has no ledge at any of them.
    EXPECT_GT(ledges, 60) << "seed " << seed;
    EXPECT_GT(least, 0.35f * spec.thick_m) << "seed " << seed;
    EXPECT_LT(most, 1.4f * spec.thick_m) << "seed " << seed;
  }
}

TEST(BeddedRock, HasNoJumps) {
  const BeddedRockSpec spec{.height_m = 6, .thick_m = 1.5f, .bed_m = 0.6f, .ledge_m = 0.08f};
  Rng rng(SceneSeed{3}, "rock");
  const BeddedRock rock(spec, rng);
  constexpr float kStep_m = 1e-4f;
  for (int i = 0; i < 40000; ++i) {
    const float angle = 2.39996f * static_cast<float>(i);
    const float z = spec.height_m * std::fmod(0.618034f * static_cast<float>(i), 1.0f);
    const float here = WornRadius(rock, spec, angle, z);
    // A ledge of a third of the radius over `ledge_m`, at most.
    EXPECT_NEAR(here, WornRadius(rock, spec, angle, z + kStep_m), 3e-3f) << angle << " " << z;
    EXPECT_NEAR(here, WornRadius(rock, spec, angle + kStep_m, z), 3e-3f) << angle << " " << z;
  }
}

}  // namespace
}  // namespace parallax
