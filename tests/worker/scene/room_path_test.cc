// Ways of the rig through rooms, several baselines, and things that move.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "common/config/config.h"
#include "common/math/sequence.h"
#include "common/math/stereo.h"
#include "worker/geometry/ray_scene.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/solve_scene.h"

namespace parallax {
namespace {

constexpr double kFps = 10;

v1::SolveJob WayJob(uint64_t seed, int paths, int count) {
  v1::SolveJob job;
  job.set_scene_seed(seed);
  v1::SceneConfig& config = *job.mutable_config();
  config = DefaultSceneConfig();
  config.mutable_solver()->set_steps(12);
  config.mutable_rigs()->set_count(count);
  config.mutable_rigs()->mutable_path()->set_paths(paths);
  config.mutable_floating()->mutable_count()->set_constant(6);
  return job;
}

v1::Scene SolvedScene(const v1::SolveJob& job) {
  const auto result = Solve(job, CancelToken());
  EXPECT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(result->has_scene()) << result->rejected().reason();
  return result->scene();
}

// Everything as it stands at that time.
RayScene SolidAt(const v1::Scene& scene, const SceneGeometry& geometry, double time_s) {
  RayScene solid;
  for (int i = 0; i < scene.objects_size(); ++i) {
    const v1::SceneObject& object = scene.objects(i);
    const PlacedMesh& placed = geometry.meshes[static_cast<size_t>(i)];
    solid.Add(*placed.mesh,
              object.has_motion() ? PoseAt(object, time_s).Affine() : placed.world_from_object);
  }
  solid.Commit();
  return solid;
}

TEST(RoomPath, FramesAreSharedEvenlyAndInTime) {
  const v1::Scene scene = SolvedScene(WayJob(1, 3, 16));
  ASSERT_EQ(scene.rigs_size(), 16);
  std::map<uint32_t, int> frames;
  for (int i = 0; i < 16; ++i) {
    const v1::Rig& rig = scene.rigs(i);
    EXPECT_EQ(rig.index(), static_cast<uint32_t>(i));
    EXPECT_NEAR(rig.time_s(), frames[rig.path()]++ / kFps, 1e-12);
  }
  EXPECT_EQ(frames, (std::map<uint32_t, int>{{1, 6}, {2, 5}, {3, 5}}));
  const std::vector<RigPlace> places = PlacesOf(scene);
  EXPECT_EQ(places[0].previous, -1);
  EXPECT_EQ(places[0].next, 1);
  EXPECT_EQ(places[5].next, -1);
  EXPECT_EQ(places[6].previous, -1);
}

TEST(RoomPath, WaysAreSmoothAndClear) {
  for (const uint64_t seed : {1, 2}) {
    v1::SolveJob job = WayJob(seed, 2, 30);
    job.mutable_config()->mutable_rigs()->mutable_path()->set_max_turn_dps(30);
    const v1::Scene scene = SolvedScene(job);
    const RayScene solid = SolidAt(scene, BuildSceneGeometry(scene).value(), 0);
    const double clearance = job.config().rigs().min_distance_m();
    for (int i = 0; i < scene.rigs_size(); ++i) {
      const v1::Rig& rig = scene.rigs(i);
      for (int eye = 0; eye < 2; ++eye) {
        EXPECT_GE(solid.NearestDistance(EyePosition(rig, eye).cast<float>(), 1), clearance) << i;
      }
      if (i == 0 || scene.rigs(i - 1).path() != rig.path()) continue;
      const v1::Rig& before = scene.rigs(i - 1);
      EXPECT_EQ(rig.baseline_m(), before.baseline_m());
      EXPECT_EQ(rig.fx_px(), before.fx_px());
      const double step = (EyePosition(rig, 0) - EyePosition(before, 0)).norm();
      EXPECT_LE(step, 1.0 / kFps + 1e-9);  // Speeds are drawn from 0.3 to 1 m/s.
      EXPECT_GE(step, 0.25 / kFps);
      const Eigen::AngleAxisd turn(RigAxes(before).transpose() * RigAxes(rig));
      EXPECT_LE(turn.angle(), 30 * std::numbers::pi / 180 / kFps + 1e-6);
    }
  }
}

TEST(RoomPath, SlowFrameRatesFollowTheWayBetweenFrames) {
  v1::SolveJob job = WayJob(1, 1, 12);
  job.mutable_config()->mutable_rigs()->mutable_path()->set_fps(0.2);
  int found = 0;
  for (const uint64_t seed : {1, 2, 3}) {
    job.set_scene_seed(seed);
    const auto result = Solve(job, CancelToken());
    ASSERT_TRUE(result.ok()) << result.status();
    found += result->has_scene();
  }
  EXPECT_GE(found, 2);
}

TEST(RoomPath, SameJobGivesTheSameWays) {
  EXPECT_EQ(SolvedScene(WayJob(2, 1, 12)).SerializeAsString(),
            SolvedScene(WayJob(2, 1, 12)).SerializeAsString());
}

TEST(Baselines, EachIsAPairOfItsOwnWithOneLeftEye) {
  v1::SolveJob job = WayJob(1, 1, 4);
  const v1::Scene single = SolvedScene(job);
  for (const double baseline : {0.06, 0.12, 0.24}) {
    job.mutable_config()->mutable_rigs()->add_baselines_m(baseline);
  }
  const v1::Scene scene = SolvedScene(job);
  ASSERT_EQ(scene.rigs_size(), 12);
  const std::vector<RigPlace> places = PlacesOf(scene);
  for (int i = 0; i < 12; ++i) {
    const v1::Rig& rig = scene.rigs(i);
    EXPECT_EQ(rig.index(), static_cast<uint32_t>(i));
    EXPECT_EQ(rig.baseline_m(), job.config().rigs().baselines_m(i % 3));
    EXPECT_EQ(rig.shares_left(), i % 3 > 0);
    EXPECT_EQ(rig.world_from_left().SerializeAsString(),
              single.rigs(i / 3).world_from_left().SerializeAsString());
    EXPECT_EQ(places[static_cast<size_t>(i)].left, i / 3 * 3);
    EXPECT_EQ(places[static_cast<size_t>(i)].next, i < 9 ? i + 3 : -1);
    EXPECT_EQ(places[static_cast<size_t>(i)].previous, i >= 3 ? i - 3 : -1);
  }
}

TEST(Motion, MovesSomeThingsClearOfCamerasAndOfAllElse) {
  v1::SolveJob job = WayJob(3, 1, 8);
  job.mutable_config()->mutable_floating()->mutable_count()->set_constant(10);
  job.mutable_config()->mutable_floating()->mutable_motion()->set_p(1);
  const v1::Scene scene = SolvedScene(job);
  const SceneGeometry geometry = BuildSceneGeometry(scene).value();
  std::vector<std::shared_ptr<const TriangleTree>> trees;
  for (const PlacedMesh& placed : geometry.meshes) {
    trees.push_back(std::make_shared<TriangleTree>(*placed.mesh));
  }
  const auto place = [&](size_t i, double time_s) {
    const v1::SceneObject& object = scene.objects(static_cast<int>(i));
    return object.has_motion() ? PoseAt(object, time_s).Affine()
                               : geometry.meshes[i].world_from_object;
  };
  for (const v1::Rig& rig : scene.rigs()) {
    RayScene solid;
    for (size_t i = 0; i < trees.size(); ++i) solid.Add(trees[i], place(i, rig.time_s()));
    solid.Commit();
    for (int k = 0; k <= 4; ++k) {
      const Vec3d eye = EyePosition(rig, 0) + k / 4.0 * rig.baseline_m() * RigAxes(rig).col(0);
      EXPECT_GE(solid.NearestDistance(eye.cast<float>(), 1), job.config().rigs().min_distance_m());
    }
    for (size_t i = 0; i < trees.size(); ++i) {
      if (!scene.objects(static_cast<int>(i)).has_motion()) continue;
      for (size_t k = 0; k < trees.size(); ++k) {
        EXPECT_TRUE(k == i ||
                    !Overlap(*trees[i], place(i, rig.time_s()), *trees[k], place(k, rig.time_s())))
            << scene.objects(static_cast<int>(i)).name() << " in "
            << scene.objects(static_cast<int>(k)).name();
      }
    }
  }
  const auto moving = std::count_if(scene.objects().begin(), scene.objects().end(),
                                    [](const auto& object) { return object.has_motion(); });
  EXPECT_GE(moving, 4);
}

TEST(Motion, NothingThatMovesSwallowsALamp) {
  v1::SolveJob job = WayJob(1, 1, 24);
  v1::SceneConfig& config = *job.mutable_config();
  config.mutable_rigs()->mutable_path()->set_fps(4);
  config.mutable_floating()->mutable_count()->set_constant(10);
  config.mutable_floating()->mutable_motion()->set_p(1);
  config.mutable_lighting()->mutable_point_lights()->set_constant(5);
  int lamps = 0, movers = 0;
  for (const uint64_t seed : {1, 2, 3}) {
    job.set_scene_seed(seed);
    const v1::Scene scene = SolvedScene(job);
    const SceneGeometry geometry = BuildSceneGeometry(scene).value();
    for (int i = 0; i < scene.objects_size(); ++i) {
      const v1::SceneObject& object = scene.objects(i);
      if (!object.has_motion()) continue;
      ++movers;
      const Box3f bounds = geometry.meshes[static_cast<size_t>(i)].mesh->Bounds();
      const Eigen::AlignedBox3d box(bounds.min().cast<double>(), bounds.max().cast<double>());
      for (const v1::Light& light : scene.lights()) {
        if (light.kind() != v1::Light::KIND_POINT) continue;
        ++lamps;
        for (const v1::Rig& rig : scene.rigs()) {
          const Pose pose = PoseAt(object, rig.time_s());
          const Vec3d at = pose.Inverse() * FromProto(light.position_m());
          EXPECT_GT(pose.scale * box.exteriorDistance(at), light.radius_m())
              << object.name() << " of seed " << seed << " at " << rig.time_s() << " s";
        }
      }
    }
  }
  EXPECT_GT(movers, 3);
  EXPECT_GT(lamps, 10);
}

TEST(Motion, LeavesSceneWithoutItAsTheyAre) {
  v1::SolveJob job = WayJob(3, 1, 6);
  v1::Scene resting = SolvedScene(job);
  job.mutable_config()->mutable_floating()->mutable_motion()->set_p(0.5);
  v1::Scene moving = SolvedScene(job);
  // The same ways; the same things as long as nothing that moves took their place.
  for (int i = 0; i < resting.rigs_size(); ++i) {
    EXPECT_EQ(resting.rigs(i).SerializeAsString(), moving.rigs(i).SerializeAsString());
  }
  for (const v1::SceneObject& object : resting.objects()) EXPECT_FALSE(object.has_motion());
}

}  // namespace
}  // namespace parallax
