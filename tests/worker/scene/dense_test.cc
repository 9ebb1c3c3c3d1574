#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "common/config/config.h"
#include "common/math/proto.h"
#include "worker/assets/asset.h"
#include "worker/geometry/triangle_tree.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/floating/warp.h"
#include "worker/scene/solve_scene.h"

namespace parallax {
namespace {

// Small classes, so that a test is quick.
v1::SceneConfig SmallDense() {
  v1::SceneConfig config = LoadSceneConfig("dense").value();
  config.mutable_floating()->mutable_count()->set_constant(40);
  for (const char* name : {"Bowl", "Book", "Vase", "Can"})
    config.mutable_floating()->add_classes(name);
  config.mutable_rigs()->set_count(5);
  return config;
}

v1::Scene DenseScene(const v1::SceneConfig& config, uint64_t seed) {
  v1::SolveJob job;
  job.set_scene_seed(seed);
  *job.mutable_config() = config;
  auto result = Solve(job, CancelToken());
  EXPECT_TRUE(result.ok()) << result.status();
  EXPECT_TRUE(result->has_scene());
  return result->scene();
}

TEST(DenseConfig, IsThePapers) {
  const v1::SceneConfig config = LoadSceneConfig("dense").value();
  EXPECT_EQ(config.type(), v1::SCENE_TYPE_DENSE);
  EXPECT_EQ(config.floating().count().constant(), 200);
  EXPECT_EQ(config.rigs().count(), 200);
  EXPECT_EQ(config.floating().distance_m().uniform().low(), 5);
  EXPECT_EQ(config.floating().distance_m().uniform().high(), 50);
  EXPECT_EQ(config.rigs().baseline_m().uniform().low(), 0.1);
  EXPECT_EQ(config.rigs().baseline_m().uniform().high(), 0.4);
}

TEST(Dense, EveryKeyframePlacesAllObjectsAnewInTheViewOfItsRig) {
  const v1::SceneConfig config = SmallDense();
  const v1::Scene scene = DenseScene(config, 4);
  ASSERT_EQ(scene.objects_size(), 40);
  ASSERT_EQ(scene.rigs_size(), 5);
  ASSERT_EQ(scene.keyframes_size(), 5);
  EXPECT_TRUE(scene.place().has_open_sky());
  const SceneGeometry geometry = BuildSceneGeometry(scene).value();
  std::set<double> baselines, strengths;
  std::set<std::string> tints;
  for (int k = 0; k < 5; ++k) {
    const v1::Rig& rig = scene.rigs(k);
    const v1::Keyframe& keyframe = scene.keyframes(k);
    baselines.insert(rig.baseline_m());
    strengths.insert(keyframe.sky().strength());
    tints.insert(keyframe.sky().tint().SerializeAsString());
    EXPECT_GE(rig.baseline_m(), 0.1);
    EXPECT_LE(rig.baseline_m(), 0.4);
    ASSERT_EQ(keyframe.world_from_object_size(), 8 * 40);
    const Pose left_from_world = FromProto(rig.world_from_left()).Inverse();
    std::vector<TriangleTree> trees;
    for (int i = 0; i < 40; ++i) {
      const Pose pose = KeyframePose(keyframe, i);
      const Mesh& mesh = *geometry.meshes[static_cast<size_t>(i)].mesh;
      const Vec3d middle = pose * mesh.Bounds().center().cast<double>();
      const double distance = middle.norm();
      EXPECT_GE(distance, 5 - 1e-3);
      EXPECT_LE(distance, 50 + 1e-3);
      // Size in proportion to distance: all look alike large.
      const double size = pose.scale * double{mesh.Bounds().diagonal().maxCoeff()};
      EXPECT_GE(size / distance, 0.5 / 5 - 1e-4);
      EXPECT_LE(size / distance, 1.0 / 5 + 1e-4);
      const Vec3d seen = left_from_world * middle;
      EXPECT_GT(seen.z(), 0);
      EXPECT_LE(std::abs(seen.x() / seen.z()) * rig.fx_px(), 1.13 * rig.width_px() / 2);
      EXPECT_LE(std::abs(seen.y() / seen.z()) * rig.fy_px(), 1.13 * rig.height_px() / 2);
      trees.emplace_back(mesh);
      for (int j = 0; j < i; ++j) {
        EXPECT_FALSE(Overlap(trees[static_cast<size_t>(i)], pose.Affine(),
                             trees[static_cast<size_t>(j)], KeyframePose(keyframe, j).Affine()))
            << scene.objects(i).name() << " and " << scene.objects(j).name();
      }
    }
    if (k > 0) {
      EXPECT_NE(keyframe.world_from_object(0), scene.keyframes(0).world_from_object(0));
    }
  }
  EXPECT_EQ(baselines.size(), 5u);
  EXPECT_EQ(strengths.size(), 5u);
  EXPECT_EQ(tints.size(), 5u);
}

// The least distance of objects from the way between the eyes, over all keyframes.
double NearestToEyes(const v1::SceneConfig& config, uint64_t seed, double reach_m) {
  const v1::Scene scene = DenseScene(config, seed);
  const SceneGeometry geometry = BuildSceneGeometry(scene).value();
  double nearest = 1e9;
  for (int k = 0; k < scene.rigs_size(); ++k) {
    const Pose world_from_left = FromProto(scene.rigs(k).world_from_left());
    for (int i = 0; i < scene.objects_size(); ++i) {
      if (!scene.objects(i).part().empty()) continue;
      const Pose pose = KeyframePose(scene.keyframes(k), i);
      const Box3f bounds = geometry.meshes[static_cast<size_t>(i)].mesh->Bounds();
      const Eigen::AlignedBox3d box(bounds.min().cast<double>(), bounds.max().cast<double>());
      for (int s = 0; s <= 16; ++s) {
        const Vec3d eye = world_from_left * Vec3d(reach_m * s / 16, 0, 0);
        nearest = std::min(nearest, pose.scale * box.exteriorDistance(pose.Inverse() * eye));
      }
    }
  }
  return nearest;
}

TEST(Dense, NoCameraStandsInAThingNorNearerThanTheConfigSays) {
  v1::SceneConfig config = SmallDense();
  config.mutable_floating()->mutable_distance_m()->mutable_uniform()->set_low(0.5);
  config.mutable_floating()->mutable_distance_m()->mutable_uniform()->set_high(4);
  config.mutable_floating()->set_size_at_m(0);
  for (const bool intersect : {false, true}) {
    config.mutable_floating()->set_allow_intersections(intersect);
    config.mutable_rigs()->set_min_distance_m(0.125);
    EXPECT_GE(NearestToEyes(config, 3, 0.4), 0.124) << intersect;
    config.mutable_rigs()->set_min_distance_m(0);
    EXPECT_GT(NearestToEyes(config, 3, 0.4), 0.04) << intersect;
  }
  // Where no distance that may be drawn is far enough, too.
  config.mutable_floating()->mutable_distance_m()->set_constant(0.5);
  config.mutable_rigs()->set_min_distance_m(2);
  EXPECT_GE(NearestToEyes(config, 3, 0.4), 1.999);
}

TEST(Dense, StreetsLeaveTheRightEyesOfAllBaselinesClear) {
  v1::SceneConfig config = LoadSceneConfig("street").value();
  config.mutable_floating()->mutable_count()->set_constant(60);
  for (const char* name : {"Bowl", "Book"}) config.mutable_floating()->add_classes(name);
  config.mutable_floating()->mutable_size_m()->set_constant(0.4);
  config.mutable_floating()->mutable_distance_m()->mutable_uniform()->set_low(0.1);
  config.mutable_floating()->mutable_distance_m()->mutable_uniform()->set_high(3);
  config.mutable_rigs()->set_count(5);
  for (const double baseline_m : {0.1, 2.0}) config.mutable_rigs()->add_baselines_m(baseline_m);
  EXPECT_GE(NearestToEyes(config, 1, 2), 0.49);
}

TEST(Dense, MoreKeyframesOnlyAdd) {
  v1::SceneConfig config = SmallDense();
  config.mutable_rigs()->set_count(2);
  const v1::Scene few = DenseScene(config, 9);
  config.mutable_rigs()->set_count(3);
  const v1::Scene many = DenseScene(config, 9);
  EXPECT_EQ(few.objects(7).SerializeAsString(), many.objects(7).SerializeAsString());
  for (int k = 0; k < 2; ++k) {
    EXPECT_EQ(few.rigs(k).SerializeAsString(), many.rigs(k).SerializeAsString());
    EXPECT_EQ(few.keyframes(k).SerializeAsString(), many.keyframes(k).SerializeAsString());
  }
  EXPECT_EQ(DenseScene(config, 9).SerializeAsString(), many.SerializeAsString());
}

TEST(Warp, BendsWithinItsBoundAndKeepsTheMeshValid) {
  for (const char* name : {"Chair", "Vase", "Bush"}) {
    for (const double amount : {0.05, 0.2}) {
      const Mesh before = MakeAsset(name, 7)->mesh;
      Mesh after = before;
      WarpMesh(3, amount, after);
      EXPECT_TRUE(ValidateMesh(after).ok()) << ValidateMesh(after);
      const float side = before.Bounds().diagonal().maxCoeff();
      float largest = 0;
      for (size_t i = 0; i < before.positions.size(); ++i) {
        largest = std::max(largest, (after.positions[i] - before.positions[i]).norm());
      }
      EXPECT_LE(largest, static_cast<float>(amount) * side * 1.0001f);
      EXPECT_GE(largest, 0.1f * static_cast<float>(amount) * side);
      // Normals still fit their triangles: hardly any turns over.
      int turned = 0;
      for (const Triangle& t : after.triangles) {
        const auto flipped = [&t](const Mesh& mesh) {
          const Vec3f& a = mesh.positions[t.a];
          const Vec3f face = (mesh.positions[t.b] - a).cross(mesh.positions[t.c] - a);
          return face.dot(mesh.normals[t.a]) < 0;
        };
        turned += flipped(after) && !flipped(before);
      }
      EXPECT_LE(turned, static_cast<int>(after.triangles.size()) / 200) << name;
      EXPECT_EQ(after.triangles.size(), before.triangles.size());
    }
  }
}

TEST(Warp, NoneLeavesTheMeshAsItIs) {
  const Mesh before = MakeAsset("Vase", 7)->mesh;
  Mesh after = before;
  WarpMesh(3, 0, after);
  EXPECT_EQ(after.positions, before.positions);
  EXPECT_EQ(after.normals, before.normals);
}

}  // namespace
}  // namespace parallax
