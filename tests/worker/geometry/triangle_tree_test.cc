#include "worker/geometry/triangle_tree.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/collision.h>
#include <gtest/gtest.h>

#include "common/base/rng.h"
#include "tests/worker/geometry/shapes.h"

namespace parallax {
namespace {

using testing::BoxMesh;
using testing::TorusMesh;

Eigen::Affine3f ShiftedBy(const Vec3f& p) { return Eigen::Affine3f(Eigen::Translation3f(p)); }

Eigen::Affine3f RandomPlace(Rng& rng, double reach, float scale = 1.0f) {
  Eigen::Quaternionf q(static_cast<float>(rng.Normal()), static_cast<float>(rng.Normal()),
                       static_cast<float>(rng.Normal()), static_cast<float>(rng.Normal()));
  Eigen::Affine3f place = Eigen::Affine3f::Identity();
  place.linear() = scale * q.normalized().toRotationMatrix();
  place.translation() =
      Vec3d(rng.Uniform(-reach, reach), rng.Uniform(-reach, reach), rng.Uniform(-reach, reach))
          .cast<float>();
  return place;
}

std::shared_ptr<fcl::BVHModel<fcl::OBBRSSd>> FclModel(const Mesh& mesh,
                                                      const Eigen::Affine3f& place) {
  auto model = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
  std::vector<fcl::Vector3d> points;
  for (const Vec3f& p : mesh.positions) points.push_back((place * p).cast<double>());
  std::vector<fcl::Triangle> triangles;
  for (const Triangle& t : mesh.triangles) triangles.emplace_back(t.a, t.b, t.c);
  model->beginModel();
  model->addSubModel(points, triangles);
  model->endModel();
  return model;
}

TEST(TriangleTree, OverlapAgreesWithFclForRandomPlacements) {
  Rng rng(SceneSeed{7}, "fcl");
  const Mesh torus = TorusMesh(0.5f, 0.12f), box = BoxMesh({0.3f, 0.05f, 0.2f});
  const TriangleTree torus_tree(torus), box_tree(box);
  int crossing = 0;
  for (int i = 0; i < 400; ++i) {
    const Eigen::Affine3f a = RandomPlace(rng, 0.1), b = RandomPlace(rng, 0.6, 1.3f);
    fcl::CollisionRequestd request;
    fcl::CollisionResultd result;
    fcl::collide(FclModel(torus, a).get(), fcl::Transform3d::Identity(), FclModel(box, b).get(),
                 fcl::Transform3d::Identity(), request, result);
    const bool ours = Overlap(torus_tree, a, box_tree, b);
    // FCL sees surfaces only, so a box that the torus holds whole is ours alone.
    if (result.isCollision()) {
      EXPECT_TRUE(ours) << i;
    }
    if (ours && !result.isCollision()) {
      EXPECT_TRUE(torus_tree.Inside(a.inverse() * b.translation())) << i;
    }
    crossing += ours;
  }
  EXPECT_GT(crossing, 100);
  EXPECT_LT(crossing, 350);
}

TEST(TriangleTree, OverlapIsSymmetric) {
  Rng rng(SceneSeed{8}, "symmetric");
  const TriangleTree torus(TorusMesh(0.5f, 0.12f)), box(BoxMesh({0.3f, 0.05f, 0.2f}));
  for (int i = 0; i < 300; ++i) {
    const Eigen::Affine3f a = RandomPlace(rng, 0.1), b = RandomPlace(rng, 0.6, 0.7f);
    EXPECT_EQ(Overlap(torus, a, box, b), Overlap(box, b, torus, a)) << i;
  }
}

TEST(TriangleTree, BoxHeldWholeOverlaps) {
  const TriangleTree big(BoxMesh({1, 1, 1})), small(BoxMesh({0.1f, 0.1f, 0.1f}));
  EXPECT_TRUE(Overlap(big, ShiftedBy({0, 0, 0}), small, ShiftedBy({0.3f, 0.2f, 0.1f})));
  EXPECT_TRUE(Overlap(small, ShiftedBy({0.3f, 0.2f, 0.1f}), big, ShiftedBy({0, 0, 0})));
  EXPECT_FALSE(Overlap(big, ShiftedBy({0, 0, 0}), small, ShiftedBy({1.2f, 0, 0})));
}

TEST(TriangleTree, RingAroundARodDoesNotOverlap) {
  const TriangleTree ring(TorusMesh(0.5f, 0.1f)), rod(BoxMesh({0.1f, 0.1f, 2.0f}));
  EXPECT_FALSE(Overlap(ring, ShiftedBy({0, 0, 0}), rod, ShiftedBy({0, 0, 0})));
  EXPECT_TRUE(Overlap(ring, ShiftedBy({0, 0, 0}), rod, ShiftedBy({0.45f, 0, 0})));
}

TEST(TriangleTree, TouchingWithinToleranceDoesNotCount) {
  const TriangleTree box(BoxMesh({0.5f, 0.5f, 0.5f}));
  const Eigen::Affine3f turned =
      ShiftedBy({0.1f, 0.05f, 0.9995f}) * Eigen::AngleAxisf(0.3f, Vec3f::UnitZ());
  EXPECT_TRUE(Overlap(box, ShiftedBy({0, 0, 0}), box, turned, 0.0f));
  EXPECT_FALSE(
      Overlap(box, ShiftedBy({0, 0, 0}), box, turned * ShiftedBy({0, 0, 0.0004f}), 0.001f));
  EXPECT_FALSE(Overlap(box, ShiftedBy({0, 0, 0}), box, ShiftedBy({1.0f, 0, 0}), 0.0f))
      << "faces that meet";
}

TEST(TriangleTree, InsideFollowsTheSolid) {
  Rng rng(SceneSeed{9}, "inside");
  const TriangleTree torus(TorusMesh(0.5f, 0.2f, 96, 48));
  for (int i = 0; i < 2000; ++i) {
    const Vec3f p =
        Vec3d(rng.Uniform(-0.8, 0.8), rng.Uniform(-0.8, 0.8), rng.Uniform(-0.3, 0.3)).cast<float>();
    const float to_ring = std::hypot(std::hypot(p.x(), p.y()) - 0.5f, p.z());
    if (std::abs(to_ring - 0.2f) < 0.005f) continue;
    EXPECT_EQ(torus.Inside(p), to_ring < 0.2f) << p.transpose();
  }
}

TEST(TriangleTree, SheetsHoldNothing) {
  // A box with one leaf above it and one beside it, whose fronts look at it.
  Mesh mesh = BoxMesh({0.3f, 0.3f, 0.3f});
  mesh.slots.push_back({"leaves", {"leaf"}, false, true});
  const auto corner = [&](const Vec3f& p) {
    testing::AddVertex(mesh, p, Vec3f::UnitZ());
    return static_cast<uint32_t>(mesh.positions.size() - 1);
  };
  const uint32_t a = corner({-2, -2, 0.6f}), b = corner({2, -2, 0.6f}), c = corner({0, 3, 0.6f});
  mesh.triangles.push_back({a, b, c, 1});
  const uint32_t d = corner({-2, -2, -0.6f}), e = corner({2, -2, -0.6f}), f = corner({0, 3, -0.6f});
  mesh.triangles.push_back({d, f, e, 1});
  const TriangleTree tree(mesh);
  EXPECT_TRUE(tree.Inside({0.1f, 0.1f, 0.1f}));
  EXPECT_FALSE(tree.Inside({0, 0.1f, 0.5f})) << "between the box and a sheet";
  EXPECT_FALSE(tree.Inside({0.5f, 0.1f, 0.1f})) << "between both sheets";
  // The same sheets taken for walls of a body do hold what lies between.
  mesh.slots[1].sheet = false;
  EXPECT_TRUE(TriangleTree(mesh).Inside({0.5f, 0.1f, 0.1f}));
  EXPECT_TRUE(Overlap(tree, ShiftedBy({0, 0, 0}), TriangleTree(BoxMesh({0.1f, 0.1f, 0.1f})),
                      ShiftedBy({0.5f, 0.1f, 0.6f})))
      << "a box through a leaf";
}

TEST(TriangleTree, DistanceToATriangleIsTheMinimumOverItsPoints) {
  Rng rng(SceneSeed{10}, "distance");
  const auto point = [&] {
    return Vec3d(rng.Uniform(-1, 1), rng.Uniform(-1, 1), rng.Uniform(-1, 1)).cast<float>().eval();
  };
  for (int i = 0; i < 100; ++i) {
    const std::array<Vec3f, 3> t = {point(), point(), point()};
    const Vec3f p = point();
    float best = 10;
    for (int u = 0; u <= 60; ++u) {
      for (int v = 0; u + v <= 60; ++v) {
        const Vec3f q = t[0] + (t[1] - t[0]) * (u / 60.0f) + (t[2] - t[0]) * (v / 60.0f);
        best = std::min(best, (p - q).norm());
      }
    }
    const float exact = PointTriangleDistance(p, t);
    EXPECT_LE(exact, best + 1e-5f);
    EXPECT_GE(exact, best - 0.06f);
  }
}

}  // namespace
}  // namespace parallax
