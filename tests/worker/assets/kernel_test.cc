#include <gtest/gtest.h>

#include <cmath>

#include "tests/worker/assets/open_edges.h"
#include "worker/assets/kernel/builder.h"
#include "worker/assets/kernel/primitives.h"
#include "worker/assets/kernel/shape_noise.h"
#include "worker/assets/kernel/soft.h"
#include "worker/assets/kernel/sweep.h"

namespace parallax::kernel {
namespace {

TEST(Kernel, SolidsAreClosedAndHaveTheVolumeOfTheirFormula) {
  const Noise noise(1);
  Path2 torus = EllipseSection(0.2f, 0.2f, 48);
  for (Vec2f& p : torus) p.x() += 1;
  const struct {
    const char* name;
    Shape shape;
    double volume;
    double tolerance;
  } cases[] = {
      {"sharp box", RoundedBox({1, 2, 3}, {.bevel_m = 0}), 6, 1e-5},
      {"rounded box", RoundedBox({1, 2, 3}, {.bevel_m = 0.01f}), 6, 2e-3},
      {"board", Board({1, 1, 1}, {0, 0, 0}), 1, 1e-3},
      {"cylinder", Cylinder(0.5f, 2, 0, 72), M_PI * 0.5, 2e-3},
      {"cone", Cone(1, 0, 3, 0, 72), M_PI, 5e-3},
      {"ball", Ball(1, 72), 4.0 / 3 * M_PI, 6e-3},
      {"ring", LatheRing(torus, 72), 2 * M_PI * M_PI * 0.01, 1e-2},
      {"tube", Tube({{0, 0, 0}, {0, 1, 0}, {0, 2, 0}}, 0.1f, 0, 48), M_PI * 0.02, 3e-3},
      {"capsule", Tube({{0, 0, 0}, {0, 2, 0}}, 0.1f, 0.1f, 48), M_PI * 0.01 * (1.8 + 0.4 / 3),
       2e-2},
      {"bar", Bar({0, 0, 0}, {0, 0, 2}, {0.1f, 0.2f}, {0.1f, 0.2f}), 0.04, 5e-3},
      {"extrusion of an L", Extrude({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}, 0.5f), 1.5,
       1e-5},
      {"sheet",
       Sheet([](float u, float v) { return Vec3f(u, v, 0); },
             {.thickness_m = 0.1f, .round_rim = false}),
       0.1, 1e-4},
      {"cushion", Cushion({0.5f, 0.5f, 0.1f}, {.piping_m = 0.004f}, noise), 0.0, -1},
      {"pillow", Pillow(0.6f, 0.4f, 0.15f, {}, noise), 0.0, -1},
      {"drape", Drape({}, noise), 0.0, -1},
  };
  for (const auto& c : cases) {
    EXPECT_EQ(OpenEdges(c.shape), 0) << c.name;
    if (c.tolerance < 0) {
      EXPECT_GT(c.shape.Volume(), 0) << c.name;
    } else {
      EXPECT_NEAR(c.shape.Volume() / c.volume, 1, c.tolerance) << c.name;
    }
  }
}

TEST(Kernel, RingOfClosedPathKeepsItsVolume) {
  Path3 path;
  for (int i = 0; i < 96; ++i) {
    const float a = 2 * kPi * static_cast<float>(i) / 96;
    path.emplace_back(std::cos(a), std::sin(a), 0);
  }
  const Shape ring = Ring(path, 0.1f, 48);
  EXPECT_EQ(OpenEdges(ring), 0);
  EXPECT_NEAR(ring.Volume() / (2 * M_PI * M_PI * 0.01), 1, 6e-3);
}

TEST(Kernel, BevelledBoxShadesItsFlatFacesFlat) {
  AssetBuilder b(1);
  b.Add(RoundedBox({1, 1, 1}, {.bevel_m = 0.002f}), Slot("wood", {"wood"}));
  const Mesh mesh = b.Finish().mesh;
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    // The flat face's own corners lie on z = 1 exactly.
    if (mesh.positions[i].z() < 1.0f - 1e-6f) continue;
    EXPECT_GT(mesh.normals[i].z(), 0.999f);
  }
}

TEST(Kernel, SharpBoxGetsThreeNormalsACorner) {
  AssetBuilder b(1);
  b.Add(RoundedBox({1, 1, 1}, {.bevel_m = 0}), Slot("wood", {"wood"}));
  EXPECT_EQ(b.mesh().positions.size(), 24u);
  EXPECT_EQ(b.mesh().triangles.size(), 12u);
}

TEST(Kernel, TextureRunsAlongTheLongestSide) {
  const Shape board = Board({0, 0, 0}, {0.02f, 0.1f, 1.5f});
  Box3f box;
  for (const Vec3f& t : board.texture) box.extend(t);
  EXPECT_NEAR(box.sizes().x(), 1.5f, 1e-5f);
}

TEST(Kernel, PartsGetTexturesOfTheirOwn) {
  AssetBuilder b(1);
  b.Add(Ball(0.1f), Slot("a", {"wood"}));
  b.Add(Ball(0.1f), Slot("a", {"wood"}));
  const size_t half = b.mesh().positions.size() / 2;
  EXPECT_GT((b.mesh().texture[0] - b.mesh().texture[half]).norm(), 0.1f);
}

TEST(Kernel, PrintedFaceCoversTheUnitSquare) {
  Shape box = Board({0, 0, 0}, {0.3f, 0.02f, 0.2f}, 0);
  PrintFaces(box, Vec3f::UnitY(), -Vec3f::UnitX(), Vec3f::UnitZ(), 1);
  Box2f uv;
  int printed = 0;
  for (const Face& f : box.faces) {
    if (f.group != 1) continue;
    ++printed;
    for (int k = 0; k < f.corners; ++k) uv.extend(f.uv[k]);
  }
  EXPECT_EQ(printed, 1);
  EXPECT_EQ(uv.min(), Vec2f(0, 0));
  EXPECT_EQ(uv.max(), Vec2f(1, 1));
}

TEST(Kernel, SplineGoesThroughItsPoints) {
  const Path3 points{{0, 0, 0}, {1, 2, 0}, {3, 1, 1}, {4, 4, 4}};
  const Path3 curve = Spline(points, 8);
  for (size_t i = 0; i < points.size(); ++i) EXPECT_LT((curve[8 * i] - points[i]).norm(), 1e-6f);
}

TEST(Kernel, SmoothFunctionDoesNotOvershoot) {
  const auto f = SmoothThrough({{0, 0}, {1, 1}, {2, 1}, {3, 0}});
  for (float x = -1; x < 4; x += 0.01f) {
    EXPECT_GE(f(x), -1e-5f);
    EXPECT_LE(f(x), 1 + 1e-5f);
  }
  EXPECT_FLOAT_EQ(f(1), 1);
}

TEST(Kernel, NoiseIsBoundedCentredAndItsSeedMatters) {
  const Noise noise(7), other(8);
  double sum = 0, square = 0, difference = 0;
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    const Vec3f p(0.37f * static_cast<float>(i % 100), 0.41f * static_cast<float>(i / 100), 0.3f);
    const double v = noise.At(p);
    EXPECT_LE(std::abs(v), 1.2);
    sum += v;
    square += v * v;
    difference += std::abs(v - other.At(p));
  }
  EXPECT_NEAR(sum / kCount, 0, 0.02);
  EXPECT_GT(square / kCount, 0.02);
  EXPECT_GT(difference / kCount, 0.05);
}

TEST(Kernel, TriangulationKeepsTheAreaOfAStar) {
  Path2 star;
  for (int i = 0; i < 20; ++i) {
    const float r = i % 2 ? 0.4f : 1.0f, a = 2 * kPi * static_cast<float>(i) / 20;
    star.emplace_back(r * std::cos(a), r * std::sin(a));
  }
  const auto area = [&](uint32_t a, uint32_t b, uint32_t c) {
    const Vec2f u = star[b] - star[a], v = star[c] - star[a];
    return 0.5f * (u.x() * v.y() - u.y() * v.x());
  };
  float whole = 0, sum = 0;
  for (uint32_t i = 0; i < 20; ++i) {
    const Vec2f &a = star[i], &b = star[(i + 1) % 20];
    whole += 0.5f * (a.x() * b.y() - a.y() * b.x());
  }
  for (const auto& [a, b, c] : Triangulate(star)) {
    EXPECT_GE(area(a, b, c), 0);
    sum += area(a, b, c);
  }
  EXPECT_NEAR(sum, whole, 1e-5f);
}

}  // namespace
}  // namespace parallax::kernel
