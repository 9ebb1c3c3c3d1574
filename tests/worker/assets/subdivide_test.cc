#include "worker/assets/kernel/subdivide.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/worker/assets/open_edges.h"
#include "worker/assets/kernel/detail_scope.h"
#include "worker/assets/kernel/primitives.h"

namespace parallax::kernel {
namespace {

Cage Box(const Vec3f& size) { return {RoundedBox(size, {.bevel_m = 0}), {}}; }

TEST(Subdivide, CagesAndWhatTheyLeadToAreClosedAndFaceOutwards) {
  Cage extruded = Box({1, 1, 1});
  const uint32_t top = NearestFace(extruded.shape, {0, 0, 0.5f});
  ExtrudeFace(extruded.shape, ExtrudeFace(extruded.shape, top, {0, 0, 1}, 0.5f), {0.4f, 0, 0.2f});
  SlabOptions ring;  // A frame round an empty cell.
  ring.columns = ring.rows = 3;
  ring.keep = [](int i, int j) { return i != 1 || j != 1; };
  ring.point = [](int i, int j) { return Vec3f(static_cast<float>(i), static_cast<float>(j), 0); };
  ring.thickness = [](int, int) { return 0.4f; };
  std::vector<CageRing> rings;
  for (int i = 0; i < 4; ++i)
    rings.push_back({EightPoints({-1, -2}, {1, 2}, static_cast<float>(i), 2.5f), 1, 1});
  for (const Cage& cage : {Box({1, 2, 3}), extruded, Slab(ring), Loft(rings)}) {
    EXPECT_EQ(OpenEdges(cage.shape), 0);
    EXPECT_GT(cage.shape.Volume(), 0);
    for (const int levels : {1, 3}) {
      const Shape smooth = Subdivided(cage, levels);
      EXPECT_EQ(OpenEdges(smooth), 0);
      EXPECT_GT(smooth.Volume(), 0);
      EXPECT_LT(smooth.Volume(), cage.shape.Volume());
      EXPECT_EQ(smooth.texture.size(), smooth.points.size());
    }
  }
}

TEST(Subdivide, LimitOfACubeIsWhatCatmullClarksRulesGive) {
  // At a corner of three edges the limit is (9 corner + 4 * edge ends + face corners) / 24.
  const Shape smooth = Subdivided(Box({2, 2, 2}), 2);
  const float expected = (9.0f * 1 + 4 * (1 + 1 - 1) + (1 - 1 - 1)) / 24;
  EXPECT_NEAR(smooth.Bounds().max().x(), smooth.Bounds().max().y(), 1e-6f);
  float corner = 0;
  for (const Vec3f& p : smooth.points) corner = std::max(corner, p.minCoeff());
  EXPECT_NEAR(corner, expected, 1e-5f);
  EXPECT_EQ(smooth.faces.size(), 6u * 16);
}

TEST(Subdivide, CreasedEdgesStayWhereTheyAre) {
  Cage cage = Box({1, 1, 1});
  for (const Face& f : cage.shape.faces) {
    for (int k = 0; k < 4; ++k) cage.creases.push_back({f.v[k], f.v[(k + 1) % 4], 10});
  }
  const Shape smooth = Subdivided(cage, 3);
  EXPECT_NEAR(smooth.Volume(), 1, 1e-5);
  EXPECT_LT(Subdivided(Box({1, 1, 1}), 3).Volume(), 0.7);
}

TEST(Subdivide, EightPointsLeadToTheCurveThatTheyName) {
  for (const float exponent : {2.0f, 3.0f, 6.0f}) {
    std::vector<CageRing> rings;
    for (int i = 0; i < 6; ++i)
      rings.push_back({EightPoints({-1, -3}, {1, 3}, static_cast<float>(i), exponent)});
    const Shape smooth = Subdivided(Loft(rings), 3);
    // Halfway up, away from the ends.
    Vec2f most = Vec2f::Zero();
    float diagonal = 0;
    for (const Vec3f& p : smooth.points) {
      if (std::abs(p.z() - 2.5f) > 0.6f) continue;
      most = most.cwiseMax(p.head<2>());
      diagonal = std::max(diagonal, std::min(p.x(), p.y() / 3));
    }
    // Squarer ones swell a little beside the sides' middles.
    const float swell = exponent > 4 ? 0.008f : 0.001f;
    EXPECT_NEAR(most.x(), 1, swell) << exponent;
    EXPECT_NEAR(most.y(), 3, 3 * swell) << exponent;
    EXPECT_NEAR(diagonal, std::pow(0.5f, 1 / exponent), 2e-3f) << exponent;
  }
}

TEST(Subdivide, GroupsAndPrintsStayOnTheirFaces) {
  Cage cage = Box({1, 1, 1});
  Face& printed = cage.shape.faces[NearestFace(cage.shape, {0, 0.5f, 0})];
  printed.group = 1;
  printed.uv = {Vec2f(0, 0), Vec2f(1, 0), Vec2f(1, 1), Vec2f(0, 1)};
  const Shape smooth = Subdivided(cage, 2);
  int count = 0;
  for (const Face& f : smooth.faces) {
    Vec3f middle = Vec3f::Zero();
    for (const uint32_t v : f.v) middle += smooth.points[v] / 4;
    EXPECT_EQ(f.group == 1, middle.y() > std::max(std::abs(middle.x()), std::abs(middle.z())));
    if (f.group != 1) continue;
    ++count;
    const Vec2f size = (f.uv[2] - f.uv[0]).cwiseAbs();
    EXPECT_GT(size.minCoeff(), 0.1f);
    EXPECT_LT(size.maxCoeff(), 0.4f);
  }
  EXPECT_EQ(count, 16);
}

TEST(Subdivide, LevelOfDetailChangesTheLevels) {
  const Cage cage = Box({1, 1, 1});
  const size_t usual = Subdivided(cage, 3).faces.size();
  const DetailScope coarse(0.5f);
  EXPECT_EQ(Subdivided(cage, 3).faces.size(), usual / 16);
  const DetailScope fine(0.06f);
  EXPECT_EQ(Subdivided(cage, 3).faces.size(), usual * 4);
}

}  // namespace
}  // namespace parallax::kernel
