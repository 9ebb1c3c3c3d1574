// Deep scenes: what rigs see of other rooms, of landscapes and of streets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "common/config/config.h"
#include "common/math/proto.h"
#include "common/math/stereo.h"
#include "worker/geometry/ray_scene.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/solve_scene.h"
#include "worker/scene/types/scene_types.h"

namespace parallax {
namespace {

using ::testing::HasSubstr;

constexpr int kProbesX = 32, kProbesY = 18;

v1::SceneConfig SmallIndoor() {
  v1::SceneConfig config = DefaultSceneConfig();
  config.mutable_solver()->set_steps(20);
  config.mutable_rigs()->set_count(6);
  config.mutable_floating()->mutable_count()->set_constant(3);
  config.mutable_lighting()->set_ceiling_removed_p(0);
  return config;
}

v1::Scene DepthScene(const v1::SceneConfig& config, uint64_t seed) {
  v1::SolveJob job;
  job.set_scene_seed(seed);
  *job.mutable_config() = config;
  const auto result = Solve(job, CancelToken());
  EXPECT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(result->has_scene()) << result->rejected().reason();
  return result->scene();
}

// All meshes of the recipe's objects, which include a landscape's ground; with `keyframe` as that
// places them.
RayScene SolidAt(const v1::Scene& scene, const v1::Keyframe* keyframe = nullptr) {
  const SceneGeometry geometry = BuildSceneGeometry(scene).value();
  RayScene solid;
  for (int i = 0; i < scene.objects_size(); ++i) {
    const PlacedMesh& placed = geometry.meshes[static_cast<size_t>(i)];
    solid.Add(*placed.mesh,
              keyframe != nullptr ? KeyframePose(*keyframe, i).Affine() : placed.world_from_object);
  }
  solid.Commit();
  return solid;
}

// Calls visit(depth, point, body) for each probe of the rig's left view that hits something;
// returns how many do not.
int Look(const RayScene& solid, const v1::Rig& rig,
         const std::function<void(double, const Vec3d&, uint32_t)>& visit) {
  const Pose pose = FromProto(rig.world_from_left());
  int missed = 0;
  for (int i = 0; i < kProbesX * kProbesY; ++i) {
    const double x = (i % kProbesX + 0.5) / kProbesX * rig.width_px();
    const double y = (i / kProbesX + 0.5) / kProbesY * rig.height_px();
    const Vec3d local((x - rig.cx_px()) / rig.fx_px(), (y - rig.cy_px()) / rig.fy_px(), 1);
    const Vec3d ray = pose.rotation * local;
    const auto hit = solid.Intersect(pose.translation.cast<float>(), ray.cast<float>());
    if (!hit) {
      ++missed;
      continue;
    }
    const double depth = double{hit->distance};
    visit(depth, pose.translation + depth * ray, hit->body);
  }
  return missed;
}

// ---- Other rooms

// Share of the probes of all rigs that end outside of the main room.
double SeenOfOtherRooms(const v1::SceneConfig& config) {
  int beyond = 0, all = 0;
  for (uint64_t seed = 0; seed < 3; ++seed) {
    const v1::Scene scene = DepthScene(config, seed);
    const v1::Room& room = scene.place().house().rooms(0);
    const Eigen::AlignedBox3d main(
        Vec3d::Constant(-0.3),
        Vec3d(room.width_m(), room.depth_m(), room.height_m()) + Vec3d::Constant(0.3));
    const RayScene solid = SolidAt(scene);
    for (const v1::Rig& rig : scene.rigs()) {
      all += kProbesX * kProbesY;
      Look(solid, rig, [&](double, const Vec3d& at, uint32_t) { beyond += !main.contains(at); });
    }
  }
  return static_cast<double>(beyond) / all;
}

TEST(OpenPlan, RigsFindPassagesAndOpenDoors) {
  v1::SceneConfig config = SmallIndoor();
  config.mutable_room()->mutable_rooms()->set_constant(4);
  config.mutable_floating()->mutable_count()->set_constant(0);
  const double closed = SeenOfOtherRooms(config);
  config.mutable_room()->set_open_door_p(1);
  const double doors = SeenOfOtherRooms(config);
  config.mutable_room()->set_open_plan_p(1);
  const double plan = SeenOfOtherRooms(config);
  EXPECT_GT(doors, closed);
  EXPECT_GT(plan, 1.5 * closed);
  EXPECT_GT(plan, 0.1);
}

// ---- Landscapes

v1::SceneConfig InLandscape(double p = 1) {
  v1::SceneConfig config = SmallIndoor();
  config.mutable_room()->set_landscape_p(p);
  config.mutable_room()->mutable_windows()->set_constant(3);
  return config;
}

TEST(Landscape, IsFarAwayAndSeenThroughWindows) {
  int far = 0, ground = 0, out_with = 0, out_without = 0;
  for (uint64_t seed = 0; seed < 4; ++seed) {
    const v1::Scene scene = DepthScene(InLandscape(), seed);
    ASSERT_TRUE(scene.place().house().has_landscape());
    EXPECT_GT(scene.place().house().landscape().instances(), 100u);
    const RayScene solid = SolidAt(scene);
    for (const v1::Rig& rig : scene.rigs()) {
      bool out = false;
      const int missed = Look(solid, rig, [&](double depth, const Vec3d& at, uint32_t body) {
        if (scene.objects(static_cast<int>(body)).part() != "landscape") return;
        ++ground;
        far += depth > 20;
        out = true;
        EXPECT_LT(at.z(), 400);
      });
      out_with += out || missed > 0;
    }
    const v1::Scene without = DepthScene(InLandscape(0), seed);
    EXPECT_FALSE(without.place().house().has_landscape());
    const RayScene house = SolidAt(without);
    for (const v1::Rig& rig : without.rigs()) {
      out_without += Look(house, rig, [](double, const Vec3d&, uint32_t) {}) > 0;
    }
  }
  EXPECT_GT(far, 40);
  EXPECT_GT(ground, far) << "near and far";
  EXPECT_GE(out_with, out_without) << "rigs look for windows that show something";
  EXPECT_GE(out_with, 10) << "of 24";
}

TEST(Landscape, LeavesTheHouseFree) {
  const v1::Scene scene = DepthScene(InLandscape(), 2);
  const v1::House& house = scene.place().house();
  const SceneGeometry geometry = BuildSceneGeometry(scene).value();
  EXPECT_FALSE(geometry.surroundings.ground_below_horizon);
  const v1::Plot& plot = house.landscape().plot();
  const Box3f rooms(Vec3d(plot.low_x_m(), plot.low_y_m(), -3).cast<float>(),
                    Vec3d(plot.high_x_m(), plot.high_y_m(), 6).cast<float>());
  EXPECT_EQ(geometry.instances.size(), house.landscape().instances());
  for (const Instance& instance : geometry.instances) {
    const Vec3f foot = instance.world_from_object.col(3);
    EXPECT_FALSE(rooms.contains(foot)) << foot.transpose();
  }
  for (size_t i = 0; i < geometry.meshes.size(); ++i) {
    if (scene.objects(static_cast<int>(i)).part() != "landscape") continue;
    for (const Vec3f& p : geometry.meshes[i].mesh->positions) {
      if (!rooms.contains(Vec3f(p.x(), p.y(), 0))) continue;
      EXPECT_LT(p.z(), -0.1f) << p.transpose();
    }
  }
}

TEST(Landscape, OtherExpansionFailsTheJobAndEqualSeedsGiveEqualBytes) {
  v1::Scene scene = DepthScene(InLandscape(), 3);
  EXPECT_EQ(scene.SerializeAsString(), DepthScene(InLandscape(), 3).SerializeAsString());
  v1::Terrain& land = *scene.mutable_place()->mutable_house()->mutable_landscape();
  land.set_expansion_hash(land.expansion_hash() ^ 1);
  const auto geometry = BuildSceneGeometry(scene);
  EXPECT_EQ(geometry.status().code(), absl::StatusCode::kInternal);
  EXPECT_THAT(std::string(geometry.status().message()), HasSubstr("expansion"));
  land.mutable_plot()->set_blend_m(-1);
  EXPECT_EQ(BuildSceneGeometry(scene).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(Landscape, ThingsHaveNamesAndTheHouseKeepsItsIndices) {
  const v1::Scene with = DepthScene(InLandscape(), 1), without = DepthScene(InLandscape(0), 1);
  for (int i = 0; i < without.objects_size(); ++i) {
    if (without.objects(i).role() == v1::OBJECT_ROLE_FLOATING) break;
    EXPECT_EQ(with.objects(i).index(), without.objects(i).index());
    EXPECT_EQ(with.objects(i).name(), without.objects(i).name());
  }
  const SceneType& type = **TypeOf(with);
  const SceneGeometry geometry = BuildSceneGeometry(with).value();
  for (const Instance& instance : geometry.instances) {
    ASSERT_TRUE(type.grown(with, instance.object_index).has_value()) << instance.object_index;
  }
  EXPECT_FALSE(type.grown(with, 1).has_value());
  EXPECT_FALSE(type.grown(without, 5000).has_value());
  EXPECT_EQ(type.describe(with).lines.size(), type.describe(without).lines.size() + 1);
}

// ---- Streets

v1::SceneConfig SmallStreet() {
  v1::SceneConfig config = LoadSceneConfig("street").value();
  config.mutable_floating()->mutable_count()->set_constant(60);
  for (const char* name : {"Bowl", "Book", "Vase", "Can", "Chair"}) {
    config.mutable_floating()->add_classes(name);
  }
  config.mutable_rigs()->set_count(6);
  return config;
}

TEST(Street, RigsStandOnTheCarriagewayAndLookAlongIt) {
  const v1::Scene scene = DepthScene(SmallStreet(), 5);
  ASSERT_TRUE(scene.place().open_sky().has_street());
  const double half = 0.5 * scene.place().open_sky().street().width_m();
  for (const v1::Rig& rig : scene.rigs()) {
    for (const int eye : {0, 1}) EXPECT_LT(std::abs(EyePosition(rig, eye).y()), half);
    const Vec3d ahead = RigAxes(rig).col(2);
    EXPECT_GT(std::abs(ahead.x()), 0.9 * ahead.head<2>().norm());
    EXPECT_LT(std::abs(ahead.z()), 0.3);
  }
}

TEST(Street, ReachesFromNearToFarAndNothingComesNearTheEyes) {
  const v1::Scene scene = DepthScene(SmallStreet(), 6);
  int near = 0, far = 0, all = 0;
  for (int k = 0; k < scene.rigs_size(); ++k) {
    const v1::Rig& rig = scene.rigs(k);
    const RayScene solid = SolidAt(scene, &scene.keyframes(k));
    for (const double t : {0.0, 0.5, 1.0}) {
      const Vec3d eye = EyePosition(rig, 0) + t * (EyePosition(rig, 1) - EyePosition(rig, 0));
      EXPECT_GT(solid.NearestDistance(eye.cast<float>(), 1), 0.42f) << k;
      EXPECT_FALSE(solid.Inside(eye.cast<float>())) << k;
    }
    Look(solid, rig, [&](double depth, const Vec3d&, uint32_t) {
      const double disparity = rig.fx_px() * rig.baseline_m() / depth;
      near += disparity > 40;
      far += disparity < 15;
      ++all;
    });
  }
  EXPECT_GT(near, 0.03 * all);
  EXPECT_GT(far, 0.2 * all);
}

TEST(Street, ThingsStandOnItsGroundAndApart) {
  const v1::Scene scene = DepthScene(SmallStreet(), 7);
  const SceneGeometry geometry = BuildSceneGeometry(scene).value();
  const v1::Keyframe& keyframe = scene.keyframes(0);
  const int things = scene.objects_size() - 1;  // The last is the street.
  EXPECT_EQ(scene.objects(things).part(), "street");
  ASSERT_TRUE(ValidateMesh(*geometry.meshes.back().mesh).ok());
  std::vector<TriangleTree> trees;
  int standing = 0;
  for (int i = 0; i < things; ++i) {
    const Pose pose = KeyframePose(keyframe, i);
    const Mesh& mesh = *geometry.meshes[static_cast<size_t>(i)].mesh;
    float lowest = 1e9f;
    for (const Vec3f& p : mesh.positions) lowest = std::min(lowest, (pose.Affine() * p).z());
    EXPECT_GT(lowest, -1e-3f) << scene.objects(i).name();
    standing += lowest < 0.2f;
    trees.emplace_back(mesh);
    for (int k = 0; k < i; ++k) {
      EXPECT_FALSE(Overlap(trees[static_cast<size_t>(i)], pose.Affine(),
                           trees[static_cast<size_t>(k)], KeyframePose(keyframe, k).Affine()));
    }
  }
  EXPECT_GT(standing, things / 2);
  EXPECT_LT(standing, things);
}

TEST(Street, EqualSeedsGiveEqualBytesAndMoreRigsOnlyAddRigs) {
  v1::SceneConfig config = SmallStreet();
  const v1::Scene scene = DepthScene(config, 8);
  EXPECT_EQ(scene.SerializeAsString(), DepthScene(config, 8).SerializeAsString());
  config.mutable_rigs()->set_count(3);
  const v1::Scene fewer = DepthScene(config, 8);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(fewer.rigs(i).SerializeAsString(), scene.rigs(i).SerializeAsString());
    EXPECT_EQ(fewer.keyframes(i).SerializeAsString(), scene.keyframes(i).SerializeAsString());
  }
}

}  // namespace
}  // namespace parallax
