#include <gtest/gtest.h>

#include <map>
#include <utility>

#include "worker/geometry/ray_scene.h"
#include "worker/scene/types/nature/ground/roof.h"
#include "worker/scene/types/nature/rules/recipe.h"
#include "worker/terrain/landforms.h"

namespace parallax {
namespace {

v1::Terrain Recipe() {
  TerrainSpec spec = *DrawLandform("cave", Rng(SceneSeed{3}));
  spec.region_samples = spec.site_samples = 129;
  spec.site_m = 300;
  spec.streams.steps = 2;
  spec.rain.droplets = 500;
  v1::Terrain recipe;
  SetTerrainSpec(spec, recipe);
  recipe.add_ground()->set_material_index(1);
  v1::CaveRoof& roof = *recipe.mutable_roof();
  roof.set_rise_m(8);
  roof.set_spring_m(2.5);
  roof.set_reach_m(20);
  roof.set_half_length_m(30);
  roof.set_object_index(2);
  roof.set_seed(7);
  const Vec2f hole = GorgeMiddle(spec.cover[0], 5);
  v1::CaveRoof::Skylight& light = *roof.add_skylights();
  light.set_x_m(static_cast<double>(hole.x()));
  light.set_y_m(static_cast<double>(hole.y()));
  light.set_radius_m(2);
  return recipe;
}

TEST(CaveRoof, IsAClosedBody) {
  const v1::Terrain recipe = Recipe();
  ASSERT_TRUE(CheckRules(recipe).ok()) << CheckRules(recipe);
  const auto terrain = TerrainOf(recipe).value();
  const CaveRoof roof(recipe, *terrain, 0.5f);
  ASSERT_TRUE(ValidateMesh(roof.mesh()).ok()) << ValidateMesh(roof.mesh());
  std::map<std::pair<uint32_t, uint32_t>, int> edges;
  for (const Triangle& t : roof.mesh().triangles) {
    for (const auto& [from, to] : {std::pair(t.a, t.b), std::pair(t.b, t.c), std::pair(t.c, t.a)}) {
      ++edges[std::pair(from, to)];
    }
  }
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, (edges[std::pair(edge.second, edge.first)]));
  }
}

TEST(CaveRoof, ItsCeilingIsWhereTheMeshIsAndSkylightsAreOpen) {
  const v1::Terrain recipe = Recipe();
  const auto terrain = TerrainOf(recipe).value();
  const TerrainTerm& gorge = terrain->spec().cover[0];
  const CaveRoof roof(recipe, *terrain, 0.25f);
  RayScene solid;
  solid.Add(roof.mesh(), Eigen::Affine3f::Identity());
  solid.Commit();
  int compared = 0;
  for (float along = -25; along <= 25; along += 2.3f) {
    const Vec2f p = GorgeMiddle(gorge, along);
    const float floor = terrain->Height(p, 0.5f);
    const auto hit = solid.Intersect(Vec3f(p.x(), p.y(), floor + 0.2f), Vec3f::UnitZ());
    const auto ceiling = roof.CeilingAt(p);
    EXPECT_GT(roof.VaultAt(p), floor + 2) << along;
    if (std::abs(along - 5) < 0.8f) {
      EXPECT_FALSE(hit.has_value()) << "the skylight is closed";
      EXPECT_FALSE(ceiling.has_value());
    }
    if (!hit || !ceiling) continue;
    EXPECT_NEAR(floor + 0.2f + hit->distance, *ceiling, 0.35f) << along;
    ++compared;
  }
  EXPECT_GT(compared, 12);
  EXPECT_FALSE(roof.CeilingAt(GorgeMiddle(gorge, 60)).has_value());
}

TEST(CaveRoof, LightHasItsWaysIn) {
  const v1::Terrain recipe = Recipe();
  const auto terrain = TerrainOf(recipe).value();
  const SkyEnclosure under = EnclosureUnder(recipe, *terrain);
  EXPECT_EQ(under.portals.size(), 3u);  // Both ends and a skylight.
  const Vec2f middle = GorgeMiddle(terrain->spec().cover[0], 0);
  EXPECT_TRUE(under.box.contains(Vec3f(middle.x(), middle.y(), terrain->Height(middle, 1) + 1)));
  // It ends at its mouths, though its box goes on where the gorge runs askew.
  ASSERT_EQ(under.within.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    const SkyPortal& mouth = under.portals[i];
    const Vec3f center = mouth.corner + 0.5f * (mouth.edge_u + mouth.edge_v);
    EXPECT_GT(under.within[i].normal.dot(center + mouth.normal), under.within[i].offset);
    EXPECT_LT(under.within[i].normal.dot(center - mouth.normal), under.within[i].offset);
  }
  v1::Terrain no_gorge = recipe;
  no_gorge.clear_cover();
  EXPECT_EQ(CheckRules(no_gorge).code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace parallax
