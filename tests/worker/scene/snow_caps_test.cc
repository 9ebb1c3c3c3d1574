#include "worker/scene/types/nature/ground/snow_caps.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "worker/assets/nature/ground_cover.h"
#include "worker/assets/nature/trees.h"

namespace parallax {
namespace {

Mesh Rock() { return MakeBoulder({.seed = 3}).mesh; }

TEST(SnowCaps, LieOnWhatLooksUpAndRunOutAtItsEdges) {
  const Mesh bare = Rock();
  Mesh mesh = bare;
  AddSnowCaps(0.1f, mesh);
  ASSERT_GT(mesh.triangles.size(), bare.triangles.size());
  EXPECT_TRUE(ValidateMesh(mesh).ok()) << ValidateMesh(mesh);
  EXPECT_EQ(mesh.slots.back().name, "snow");
  // The rock itself stays.
  EXPECT_TRUE(std::equal(bare.positions.begin(), bare.positions.end(), mesh.positions.begin()));
  float highest = 0;
  for (const Vec3f& p : bare.positions) highest = std::max(highest, p.z());
  const Box3f box = mesh.Bounds();
  EXPECT_GT(box.max().z(), highest + 0.04f);
  EXPECT_LT(box.max().z(), highest + 0.2f);
  EXPECT_NEAR(box.sizes().x(), bare.Bounds().sizes().x(), 1e-5f);
  for (size_t i = bare.triangles.size(); i < mesh.triangles.size(); ++i) {
    const Triangle& t = mesh.triangles[i];
    EXPECT_EQ(mesh.slots[t.slot].name, "snow");
    for (const uint32_t v : {t.a, t.b, t.c}) EXPECT_GE(v, bare.positions.size());
  }
}

// On the twigs of a bush snow stands no higher than they are wide, else it hangs in shards.
TEST(SnowCaps, AreThinOnTwigs) {
  Rng rng(SceneSeed{4}, "bush");
  const Mesh bare = SampleDryBush(rng).mesh;
  Mesh mesh = bare;
  AddSnowCaps(0.1f, mesh);
  ASSERT_GT(mesh.triangles.size(), bare.triangles.size());
  double thick = 0, all = 0;
  for (size_t i = bare.positions.size(); i < mesh.positions.size(); ++i) {
    float nearest = 1e9f;
    for (const Vec3f& p : bare.positions)
      nearest = std::min(nearest, (mesh.positions[i] - p).norm());
    thick += nearest > 0.03f ? 1 : 0;
    ++all;
  }
  EXPECT_LT(thick, 0.05 * all);
}

TEST(SnowCaps, CoverMostNeedlesButNotAll) {
  ConiferParams params;
  params.seed = 5;
  const Mesh bare = MakeConifer(params).mesh;
  Mesh mesh = bare;
  AddSnowCaps(0.08f, mesh);
  EXPECT_TRUE(ValidateMesh(mesh).ok()) << ValidateMesh(mesh);
  const auto sheets = [](const Mesh& of, bool snow) {
    return std::count_if(of.triangles.begin(), of.triangles.end(), [&](const Triangle& t) {
      return of.slots[t.slot].sheet && (of.slots[t.slot].name == "snow sheets") == snow;
    });
  };
  EXPECT_GT(sheets(mesh, true), 0.3 * static_cast<double>(sheets(bare, false)));
  EXPECT_LT(sheets(mesh, true), 0.9 * static_cast<double>(sheets(bare, false)));
}

TEST(SnowCaps, NoneLieWhereThereIsNoSnow) {
  Mesh mesh = Rock();
  const size_t triangles = mesh.triangles.size();
  AddSnowCaps(0, mesh);
  EXPECT_EQ(mesh.triangles.size(), triangles);
}

}  // namespace
}  // namespace parallax
