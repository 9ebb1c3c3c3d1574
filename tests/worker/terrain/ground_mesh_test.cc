#include "worker/terrain/ground_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "common/base/rng.h"
#include "worker/terrain/landforms.h"

namespace parallax {
namespace {

const Terrain& Ground() {
  static const Terrain* const terrain = [] {
    TerrainSpec spec = *DrawLandform("hills", Rng(SceneSeed{7}));
    spec.region_samples = spec.site_samples = 129;
    spec.streams.steps = 12;
    spec.rain.droplets = 2000;
    return new Terrain(MakeTerrain(spec));
  }();
  return *terrain;
}

GroundMeshOptions Options(int most_triangles = 60'000) {
  GroundMeshOptions options;
  options.views = {{.apex = {0, 0}, .heading_rad = 0.4f}, {.apex = {3, 1}, .heading_rad = 0.7f}};
  options.most_triangles = most_triangles;
  return options;
}

// Each inner edge belongs to two triangles that run it in opposite directions: no cracks, no
// T-junctions. Edges of the outer border belong to one.
TEST(GroundMesh, IsOneSheetWithoutCracks) {
  const GroundMesh ground(Ground(), Options());
  ASSERT_TRUE(ValidateMesh(ground.mesh()).ok()) << ValidateMesh(ground.mesh());
  std::map<std::pair<uint32_t, uint32_t>, int> edges;
  for (const Triangle& t : ground.mesh().triangles) {
    for (const auto& [from, to] : {std::pair(t.a, t.b), std::pair(t.b, t.c), std::pair(t.c, t.a)}) {
      EXPECT_EQ(++edges[std::pair(from, to)], 1) << "an edge is run twice in one direction";
    }
  }
  int open = 0;
  for (const auto& [edge, count] : edges) {
    if (edges.contains(std::pair(edge.second, edge.first))) continue;
    const Vec3f &a = ground.mesh().positions[edge.first], &b = ground.mesh().positions[edge.second];
    const bool border =
        std::max(a.head<2>().cwiseAbs().maxCoeff(), b.head<2>().cwiseAbs().maxCoeff()) > 27'999;
    EXPECT_TRUE(border) << a.transpose();
    ++open;
  }
  EXPECT_GT(open, 0);
}

TEST(GroundMesh, FacesUpAndKeepsItsBudget) {
  for (const int budget : {20'000, 60'000}) {
    const GroundMesh ground(Ground(), Options(budget));
    EXPECT_LE(ground.mesh().triangles.size(), static_cast<size_t>(budget));
    EXPECT_GE(ground.mesh().triangles.size(), static_cast<size_t>(budget) / 2);
    for (const Triangle& t : ground.mesh().triangles) {
      const Vec3f &a = ground.mesh().positions[t.a], &b = ground.mesh().positions[t.b],
                  &c = ground.mesh().positions[t.c];
      ASSERT_GT((b - a).cross(c - a).z(), 0);
    }
  }
}

TEST(GroundMesh, IsFinerInViewThanBehind) {
  const GroundMesh ground(Ground(), Options());
  int ahead = 0, behind = 0;
  for (const Vec3f& p : ground.mesh().positions) {
    if (p.head<2>().norm() > 60) continue;
    (Vec2f(std::cos(0.5f), std::sin(0.5f)).dot(p.head<2>()) > 10 ? ahead : behind) += 1;
  }
  EXPECT_GT(ahead, 2000);
  const auto count = [&](const Vec2f& center) {
    int n = 0;
    for (const Vec3f& p : ground.mesh().positions) n += (p.head<2>() - center).norm() < 8;
    return n;
  };
  EXPECT_GT(count({26, 14}), 4 * count({-26, -14}));
}

TEST(GroundMesh, HeightAtIsThatOfTheTriangles) {
  const GroundMesh ground(Ground(), Options());
  Rng rng(SceneSeed{3});
  const Mesh& mesh = ground.mesh();
  for (int i = 0; i < 2000; ++i) {
    const auto index =
        static_cast<size_t>(rng.UniformInt(0, static_cast<int>(mesh.triangles.size()) - 1));
    const Triangle& t = mesh.triangles[index];
    float u = static_cast<float>(rng.Uniform()), v = static_cast<float>(rng.Uniform());
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Vec3f p = mesh.positions[t.a] + u * (mesh.positions[t.b] - mesh.positions[t.a]) +
                    v * (mesh.positions[t.c] - mesh.positions[t.a]);
    const float scale = (mesh.positions[t.b] - mesh.positions[t.a]).norm();
    EXPECT_NEAR(ground.HeightAt(p.head<2>()), p.z(), 1e-3f + 1e-3f * scale);
  }
}

TEST(GroundMesh, StaysNearTheTerrainWhereTheWalkIs) {
  const GroundMesh ground(Ground(), Options(200'000));
  for (float x = 2; x < 30; x += 0.37f) {
    const Vec2f p(x, 0.5f * x);
    EXPECT_NEAR(ground.HeightAt(p), Ground().Height(p, 0.05f), 0.15f) << x;
  }
}

// Beds of rock stand out of a wall; what asks for heights does not see them.
TEST(GroundMesh, LedgesOverhangAndLeaveTheMeshWhole) {
  TerrainSpec spec = *DrawLandform("cliff", Rng(SceneSeed{2}));
  spec.region_samples = spec.site_samples = 257;
  spec.site_m = 400;
  spec.streams.steps = 4;
  spec.rain.droplets = 2000;
  const Terrain terrain = MakeTerrain(spec);
  ASSERT_TRUE(terrain.has_ledges());
  GroundMeshOptions options = Options(150'000);
  options.views[0].apex = ScarpFoot(spec.cover[0], 0, -40);
  options.views[0].half_angle_rad = 4;
  const GroundMesh ground(terrain, options);
  ASSERT_TRUE(ValidateMesh(ground.mesh()).ok()) << ValidateMesh(ground.mesh());
  int overhangs = 0;
  for (const Triangle& t : ground.mesh().triangles) {
    const Vec3f &a = ground.mesh().positions[t.a], &b = ground.mesh().positions[t.b],
                &c = ground.mesh().positions[t.c];
    overhangs += (b - a).cross(c - a).z() < 0;
  }
  EXPECT_GT(overhangs, 30);
  for (float along = -60; along < 60; along += 7) {
    const Vec2f p = ScarpFoot(spec.cover[0], along, -30);
    EXPECT_NEAR(ground.HeightAt(p), terrain.Height(p, 0.3f), 0.4f);
  }
}

// The mesh averages ledges that are thinner than the gap between its vertices: such a ledge would
// move one column of vertices and miss the next.
TEST(GroundMesh, LedgesThatItCannotShowStandOutByTheirMean) {
  const float steep = 6;
  MeshedSurface face;
  face.slot = face.family = "soil";
  face.height = [steep](const Vec2f& p, float) { return steep * p.x(); };
  face.slope = [steep](const Vec2f&, float) { return Vec2f(steep, 0); };
  face.steepness = [steep](const Vec2f&) { return steep; };
  face.ledge = [](const Vec2f&, float height_m) {
    const float level = height_m / 0.77f;
    return level - std::floor(level) < 0.5f ? 1.0f : 0.0f;
  };
  GroundMeshOptions options = Options(4000);
  options.reach_m = 200;
  const GroundMesh ground(face, options);
  size_t means = 0;
  for (const Vec3f& at : ground.mesh().positions) {
    const float out = at.z() / steep - at.x();  // Downhill is -x.
    means += out > 0.1f && out < 0.9f;
  }
  EXPECT_GT(means, ground.mesh().positions.size() * 8 / 10);
}

// A ledge whose edge rises along the wall would step from one column of vertices to the next.
TEST(GroundMesh, EdgesOfLedgesAreNoCombs) {
  const float steep = 6, reach = 2;
  MeshedSurface face;
  face.slot = face.family = "soil";
  face.height = [steep](const Vec2f& p, float) { return steep * p.x(); };
  face.slope = [steep](const Vec2f&, float) { return Vec2f(steep, 0); };
  face.steepness = [steep](const Vec2f&) { return steep; };
  face.ledge = [reach](const Vec2f& p, float height_m) {
    return height_m > 0.7f * p.y() ? reach : 0.0f;
  };
  GroundMeshOptions options = Options(4000);
  options.reach_m = 200;
  const GroundMesh ground(face, options);
  const auto out = [&](uint32_t v) {
    const Vec3f& at = ground.mesh().positions[v];
    return at.z() / steep - at.x();
  };
  float largest = 0;
  for (const Triangle& t : ground.mesh().triangles) {
    const float corners[] = {out(t.a), out(t.b), out(t.c)};
    const auto [least, most] = std::minmax_element(std::begin(corners), std::end(corners));
    largest = std::max(largest, *most - *least);
  }
  EXPECT_GT(largest, 0.1f * reach);
  EXPECT_LT(largest, 0.5f * reach);
}

}  // namespace
}  // namespace parallax
