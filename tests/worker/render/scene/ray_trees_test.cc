#include "worker/render/scene/ray_trees.h"

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
  for (const int every : {0, 1, 2}) {
    const TestScene test = test::MakeBoxRoom();
    const auto scene = *RenderScene::Build(test.geometry, 0, test::MoversOfEvery(every, test));
    const RayTrees& trees = scene->trees();
    Rng rng(SceneSeed{1}, "packets");
    int differ = 0, rays_traced = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vec3f eye(0.5f, 0.2f, 1.4f), ahead = AnyDirection(rng);
      Mask8 asked{};
      Rays8 rays{Vec3x8(eye), Vec3x8::Zero()};
      for (int k = 0; k < kLanes; ++k) {
        rays.direction.Set(k, (ahead + 0.01f * AnyDirection(rng)).normalized());
        asked[k] = (i >> (k % 4) & 1) != 0 || k == i % kLanes ? -1 : 0;
      }
      for (const Tree tree : {Tree::kFast, Tree::kRobust}) {
        for (const bool coherent : {true, false}) {
          Hits8 hits;
          trees.Intersect(tree, rays, asked, coherent, &hits);
          ASSERT_FALSE(Any(hits.met & ~asked));
          for (int k = 0; k < kLanes; ++k) {
            if (asked[k] == 0) continue;
            const Ray ray{eye, rays.direction.Get(k)};
            RawHit alone;
            ASSERT_EQ(trees.Intersect(Tree::kRobust, ray, 0, &alone), hits.met[k] != 0);
            ++rays_traced;
            const RawHit hit = hits.Get(k);
            if (alone.placed != hit.placed || alone.triangle != hit.triangle) {
              ++differ;  // Along an edge.
              continue;
            }
            EXPECT_NEAR(hit.distance, alone.distance, 1e-5f);
            EXPECT_NEAR(hit.u, alone.u, 1e-4f);
            EXPECT_NEAR((hit.position - alone.position).norm(), 0, 1e-5f);
            EXPECT_NEAR((hit.edge_cross - alone.edge_cross).norm(), 0, 1e-5f);
          }
        }
      }
    }
    EXPECT_LT(differ, rays_traced / 1000);
  }
}

}  // namespace
}  // namespace parallax
