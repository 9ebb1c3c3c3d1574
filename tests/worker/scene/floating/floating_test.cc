// Floating objects in rooms: where the config's placements put them, warps, intersections.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "common/config/config.h"
#include "common/math/proto.h"
#include "worker/geometry/ray_scene.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/solve_scene.h"

namespace parallax {
namespace {

v1::SolveJob FloatingJob(uint64_t seed) {
  v1::SolveJob job;
  job.set_scene_seed(seed);
  v1::SceneConfig& config = *job.mutable_config();
  config = DefaultSceneConfig();
  config.mutable_solver()->set_steps(12);
  config.mutable_rigs()->set_count(2);
  config.mutable_floating()->mutable_count()->set_constant(8);
  return job;
}

v1::Scene FloatingScene(const v1::SolveJob& job) {
  const auto result = Solve(job, CancelToken());
  EXPECT_TRUE(result.ok() && result->has_scene()) << result.status();
  return result->scene();
}

struct Floating {
  const v1::SceneObject* object;
  std::shared_ptr<const Mesh> mesh;
  Eigen::Affine3f place;
  Vec3d middle;  // Centre of its bounds, world.
};

struct Solids {
  explicit Solids(const v1::Scene& scene) : geometry(BuildSceneGeometry(scene).value()) {
    for (int i = 0; i < scene.objects_size(); ++i) {
      const PlacedMesh& placed = geometry.meshes[static_cast<size_t>(i)];
      if (scene.objects(i).role() == v1::OBJECT_ROLE_FLOATING) {
        floating.push_back(
            {&scene.objects(i), placed.mesh, placed.world_from_object,
             (placed.world_from_object * placed.mesh->Bounds().center()).cast<double>()});
      } else {
        rest.push_back(placed);
      }
    }
  }
  SceneGeometry geometry;
  std::vector<Floating> floating;
  std::vector<PlacedMesh> rest;
};

int CountOverlaps(const Solids& solids) {
  std::vector<TriangleTree> trees, others;
  for (const Floating& f : solids.floating) trees.emplace_back(*f.mesh);
  for (const PlacedMesh& other : solids.rest) others.emplace_back(*other.mesh);
  int count = 0;
  for (size_t i = 0; i < trees.size(); ++i) {
    for (size_t k = 0; k < others.size(); ++k) {
      count +=
          Overlap(trees[i], solids.floating[i].place, others[k], solids.rest[k].world_from_object);
    }
    for (size_t k = 0; k < i; ++k) {
      count += Overlap(trees[i], solids.floating[i].place, trees[k], solids.floating[k].place);
    }
  }
  return count;
}

TEST(Floating, OfPlacementBoxHaveTheirMiddlesInTheBox) {
  v1::SolveJob job = FloatingJob(3);
  v1::FloatingBox& box = *job.mutable_config()->mutable_floating()->mutable_box();
  box.set_min_x_m(0.6);
  box.set_max_x_m(2.4);
  box.set_min_y_m(0.6);
  box.set_max_y_m(2.4);
  box.set_min_z_m(1.2);
  box.set_max_z_m(1.9);
  const v1::Scene scene = FloatingScene(job);
  const Solids solids(scene);
  ASSERT_GE(solids.floating.size(), 3u);
  for (const Floating& f : solids.floating) {
    EXPECT_TRUE((f.middle.array() > Vec3d(0.599, 0.599, 1.199).array()).all() &&
                (f.middle.array() < Vec3d(2.401, 2.401, 1.901).array()).all())
        << f.object->name() << " at " << f.middle.transpose();
  }
}

TEST(Floating, OfPlacementViewStandBeforeTheRigTheyWerePlacedFor) {
  v1::SolveJob job = FloatingJob(4);
  v1::FloatingConfig& floating = *job.mutable_config()->mutable_floating();
  floating.set_placement(v1::FloatingConfig::PLACEMENT_VIEW);
  floating.set_view_rig(1);
  floating.mutable_distance_m()->mutable_uniform()->set_low(1.2);
  floating.mutable_distance_m()->mutable_uniform()->set_high(2.5);
  const v1::Scene scene = FloatingScene(job);
  const Solids solids(scene);
  ASSERT_GE(solids.floating.size(), 3u);
  RayScene room;
  for (const PlacedMesh& placed : solids.rest) room.Add(*placed.mesh, placed.world_from_object);
  room.Commit();
  const v1::Rig& rig = scene.rigs(1);
  const Pose pose = FromProto(rig.world_from_left());
  for (const Floating& f : solids.floating) {
    const Vec3d way = f.middle - pose.translation;
    EXPECT_GT(way.norm(), 1.199) << f.object->name();
    EXPECT_LT(way.norm(), 2.501) << f.object->name();
    const Vec3d seen = pose.rotation.conjugate() * way;
    ASSERT_GT(seen.z(), 0) << f.object->name();
    EXPECT_LE(std::abs(seen.x() / seen.z() * rig.fx_px()), rig.width_px() / 2.0 + 0.01);
    EXPECT_LE(std::abs(seen.y() / seen.z() * rig.fy_px()), rig.height_px() / 2.0 + 0.01);
    const auto hit = room.Intersect(pose.translation.cast<float>(), way.normalized().cast<float>());
    ASSERT_TRUE(hit.has_value());
    EXPECT_GT(hit->distance, way.norm()) << f.object->name() << " is behind something";
  }
}

TEST(Floating, WarpedOnesTouchNothingAndKeepTheirSize) {
  v1::SolveJob job = FloatingJob(6);
  job.mutable_config()->mutable_floating()->mutable_count()->set_constant(14);
  job.mutable_config()->mutable_floating()->mutable_warp()->set_constant(0.2);
  const v1::Scene scene = FloatingScene(job);
  const Solids solids(scene);
  ASSERT_GE(solids.floating.size(), 5u);
  EXPECT_EQ(CountOverlaps(solids), 0);
  job.mutable_config()->mutable_floating()->mutable_warp()->set_constant(0);
  const v1::Scene straight = FloatingScene(job);
  const Solids unwarped(straight);
  for (const Floating& f : solids.floating) {
    EXPECT_NE(f.object->warp_seed(), 0u);
    const double side =
        f.mesh->Bounds().diagonal().maxCoeff() * f.object->world_from_object().scale();
    EXPECT_GT(side, 0.499) << f.object->name();
    EXPECT_LT(side, 1.001) << f.object->name();
    for (const Floating& before : unwarped.floating) {
      if (before.object->name() != f.object->name()) continue;
      EXPECT_NE(before.mesh->Bounds().diagonal(), f.mesh->Bounds().diagonal()) << f.object->name();
    }
  }
}

TEST(Floating, MayIntersectOnlyWhereTheConfigLetsThem) {
  v1::SolveJob job = FloatingJob(6);
  job.mutable_config()->mutable_floating()->mutable_count()->set_constant(14);
  const v1::Scene apart = FloatingScene(job);
  EXPECT_EQ(CountOverlaps(Solids(apart)), 0);
  job.mutable_config()->mutable_floating()->set_allow_intersections(true);
  const v1::Scene meeting = FloatingScene(job);
  EXPECT_GT(CountOverlaps(Solids(meeting)), 0);
}

}  // namespace
}  // namespace parallax
