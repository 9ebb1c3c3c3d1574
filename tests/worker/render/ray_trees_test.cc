#include "worker/render/ray_trees.h"

#include <gtest/gtest.h>

#include <array>
#include <map>

#include "common/base/rng.h"
#include "tests/worker/render/radiance.h"

namespace parallax {
namespace {

using test::Build;
using test::Built;
using test::TestScene;
using Tree = RayTrees::Tree;

Vec3f AnyDirection(Rng& rng) {
  return Vec3f(static_cast<float>(rng.Normal()), static_cast<float>(rng.Normal()),
               static_cast<float>(rng.Normal()))
      .normalized();
}

// Vertices that lie together get the same position, to the last bit.
std::shared_ptr<const Mesh> Welded(const Mesh& mesh) {
  auto welded = std::make_shared<Mesh>(mesh);
  std::map<std::array<int64_t, 3>, Vec3f> first;
  for (Vec3f& p : welded->positions) {
    std::array<int64_t, 3> key;
    for (int k = 0; k < 3; ++k) key[static_cast<size_t>(k)] = std::llround(p[k] * 1e4);
    p = first.emplace(key, p).first->second;
  }
  return welded;
}

// Rays that run exactly to the corners and to the middles of the edges of a closed ball.
TEST(RayTrees, OnlyTheFastTreeIsTornAlongItsEdges) {
  TestScene test;
  const auto ball = Welded(*test::MakeSphere({0.3f, -0.2f, 0.1f}, 1.7f, 64));
  test.AddMesh(ball, 0);
  const Built built = Build(test);
  const Vec3f eye(0.1f, 0.05f, -0.3f);
  int64_t robust = 0, fast = 0;  // Rays that slipped through.
  for (const Triangle& t : ball->triangles) {
    const Vec3f a = ball->positions[t.a], b = ball->positions[t.b], c = ball->positions[t.c];
    for (const Vec3f& at : {a, b, c, Vec3f(0.5f * (a + b)), Vec3f(0.5f * (b + c))}) {
      Ray ray;
      ray.origin = eye;
      ray.direction = (at - eye).normalized();
      RawHit hit;
      robust += built.scene->trees().Intersect(Tree::kRobust, ray, 0, &hit) ? 0 : 1;
      fast += built.scene->trees().Intersect(Tree::kFast, ray, 0, &hit) ? 0 : 1;
    }
  }
  const auto rays = static_cast<int64_t>(5 * ball->triangles.size());
  EXPECT_GT(fast, rays / 20);  // Or one tree would do.
  EXPECT_LT(robust, rays / 200);
}

TEST(RayTrees, BothTreesAndPacketsMeetTheSame) {
  for (const bool movable : {false, true}) {
    const TestScene test = test::MakeBoxRoom();
    const auto scene = *RenderScene::Build(test.geometry, 0, movable);
    const RayTrees& trees = scene->trees();
    Rng rng(SceneSeed{1}, "packets");
    int differ = 0, rays_traced = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vec3f eye(0.5f, 0.2f, 1.4f), ahead = AnyDirection(rng);
      const int count = 1 + i % RayTrees::kPacket;
      std::array<Ray, RayTrees::kPacket> rays;
      std::array<RawHit, RayTrees::kPacket> hits;
      std::array<const Ray*, RayTrees::kPacket> ray_of{};
      std::array<RawHit*, RayTrees::kPacket> hit_of{};
      for (size_t k = 0; k < rays.size(); ++k) {
        rays[k].origin = eye;
        rays[k].direction = (ahead + 0.01f * AnyDirection(rng)).normalized();
        ray_of[k] = &rays[k];
        hit_of[k] = &hits[k];
      }
      for (const Tree tree : {Tree::kFast, Tree::kRobust}) {
        const uint32_t met = trees.Intersect(tree, ray_of.data(), hit_of.data(), count);
        ASSERT_EQ(met >> count, 0u);
        for (int k = 0; k < count; ++k) {
          const auto n = static_cast<size_t>(k);
          RawHit alone;
          ASSERT_EQ(trees.Intersect(Tree::kRobust, rays[n], 0, &alone), (met >> k & 1) != 0);
          ++rays_traced;
          if (alone.placed != hits[n].placed || alone.triangle != hits[n].triangle) {
            ++differ;  // Along an edge.
            continue;
          }
          EXPECT_NEAR(hits[n].distance, alone.distance, 1e-5f);
          EXPECT_NEAR(hits[n].u, alone.u, 1e-4f);
          EXPECT_NEAR((hits[n].position - alone.position).norm(), 0, 1e-5f);
          EXPECT_NEAR((hits[n].edge_cross - alone.edge_cross).norm(), 0, 1e-5f);
        }
      }
    }
    EXPECT_LT(differ, rays_traced / 1000);
  }
}

}  // namespace
}  // namespace parallax
