#include "worker/scene/solve_scene.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "common/config/config.h"
#include "common/math/proto.h"
#include "worker/assets/asset.h"
#include "worker/geometry/ray_scene.h"
#include "worker/materials/kernel/material.h"
#include "worker/scene/build_geometry.h"

namespace parallax {
namespace {

v1::SolveJob JobOf(uint64_t seed) {
  v1::SolveJob job;
  job.set_scene_seed(seed);
  *job.mutable_config() = DefaultSceneConfig();
  job.mutable_config()->mutable_floating()->mutable_count()->mutable_uniform_int()->set_low(4);
  job.mutable_config()->mutable_floating()->mutable_count()->mutable_uniform_int()->set_high(10);
  job.mutable_config()->mutable_rigs()->set_count(6);
  return job;
}

v1::SolveResult SolveOf(const v1::SolveJob& job) {
  auto result = Solve(job, CancelToken());
  EXPECT_TRUE(result.ok()) << result.status();
  result->clear_layout_s();
  result->clear_dress_s();
  return *std::move(result);
}

v1::Scene SceneOf(const v1::SolveJob& job) {
  v1::SolveResult result = SolveOf(job);
  EXPECT_TRUE(result.has_scene()) << result.rejected().reason();
  return result.scene();
}

std::vector<std::string> ObjectsWithoutMaterials(const v1::Scene& scene) {
  std::vector<std::string> out;
  for (v1::SceneObject object : scene.objects()) {
    object.clear_materials();
    out.push_back(object.SerializeAsString());
  }
  return out;
}

std::vector<std::string> RigsWithoutBaseline(const v1::Scene& scene) {
  std::vector<std::string> out;
  for (v1::Rig rig : scene.rigs()) {
    rig.clear_baseline_m();
    out.push_back(rig.SerializeAsString());
  }
  return out;
}

RayScene SolidOf(const v1::Scene& scene) {
  RayScene solid;
  const SceneGeometry geometry = BuildSceneGeometry(scene).value();
  for (const PlacedMesh& placed : geometry.meshes) {
    solid.Add(*placed.mesh, placed.world_from_object);
  }
  solid.Commit();
  return solid;
}

TEST(Solve, SameJobGivesTheSameBytes) {
  for (uint64_t seed = 0; seed < 3; ++seed) {
    EXPECT_EQ(SolveOf(JobOf(seed)).SerializeAsString(), SolveOf(JobOf(seed)).SerializeAsString());
  }
}

TEST(Solve, GivenLayoutGivesTheSameSceneAsSolvingIt) {
  v1::SolveJob job = JobOf(4);
  const v1::SolveResult first = SolveOf(job);
  *job.mutable_layout() = first.layout();
  const v1::SolveResult second = SolveOf(job);
  EXPECT_FALSE(second.has_layout());
  EXPECT_EQ(first.scene().SerializeAsString(), second.scene().SerializeAsString());
}

void ExpectNamedAndBound(const v1::Scene& scene) {
  std::set<uint32_t> objects, materials;
  std::set<std::string> names;
  for (const auto& m : scene.materials()) EXPECT_TRUE(materials.insert(m.index()).second);
  for (const auto& o : scene.objects()) {
    EXPECT_GE(o.index(), 1u);
    EXPECT_TRUE(objects.insert(o.index()).second);
    EXPECT_TRUE(names.insert(o.name()).second) << o.name();
  }
  for (const auto& light : scene.lights()) {
    if (light.kind() == v1::Light::KIND_MESH) {
      EXPECT_TRUE(objects.contains(light.object_index()));
    }
  }
  const SceneGeometry geometry = BuildSceneGeometry(scene).value();
  for (const PlacedMesh& placed : geometry.meshes) {
    for (const uint32_t m : placed.material_of_slot) EXPECT_GT(m, 0u);
  }
}

void ExpectFloatingTouchNothing(const v1::Scene& scene) {
  const SceneGeometry geometry = BuildSceneGeometry(scene).value();
  std::vector<TriangleTree> trees;
  for (const PlacedMesh& placed : geometry.meshes) trees.emplace_back(*placed.mesh);
  int floating = 0;
  for (int i = 0; i < scene.objects_size(); ++i) {
    if (scene.objects(i).role() != v1::OBJECT_ROLE_FLOATING) continue;
    ++floating;
    for (int k = 0; k < scene.objects_size(); ++k) {
      if (k == i) continue;
      EXPECT_FALSE(Overlap(trees[i], geometry.meshes[i].world_from_object, trees[k],
                           geometry.meshes[k].world_from_object))
          << scene.objects(i).name() << " and " << scene.objects(k).name();
    }
    const double size = geometry.meshes[i].mesh->Bounds().diagonal().maxCoeff() *
                        scene.objects(i).world_from_object().scale();
    EXPECT_GT(size, 0.499);
    EXPECT_LT(size, 1.001);
  }
  EXPECT_GT(floating, 1);
}

void ExpectRigsClear(const v1::Scene& scene) {
  const RayScene solid = SolidOf(scene);
  EXPECT_EQ(scene.rigs_size(), 6);
  for (const v1::Rig& rig : scene.rigs()) {
    EXPECT_GE(rig.baseline_m(), 0.04);
    EXPECT_LE(rig.baseline_m(), 0.4);
    const Pose pose = FromProto(rig.world_from_left());
    // No roll: the baseline is level and the image's down points down.
    EXPECT_NEAR((pose.rotation * Vec3d::UnitX()).z(), 0, 1e-6);
    EXPECT_LT((pose.rotation * Vec3d::UnitY()).z(), 0);
    for (int k = 0; k <= 20; ++k) {
      const Vec3d at = pose * Vec3d(k / 20.0 * 0.4, 0, 0);
      EXPECT_GE(solid.NearestDistance(at.cast<float>(), 1.0f), 0.125f);
    }
    EXPECT_FALSE(solid.Inside(pose.translation.cast<float>()));
  }
}

TEST(Solve, ScenesOfManySeedsAreNamedBoundAndClear) {
  for (uint64_t seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const v1::Scene scene = SceneOf(JobOf(seed));
    ExpectNamedAndBound(scene);
    ExpectFloatingTouchNothing(scene);
    ExpectRigsClear(scene);
  }
}

TEST(Solve, MaterialModeChangesNeitherObjectsNorRigs) {
  v1::SolveJob job = JobOf(5);
  const v1::Scene all = SceneOf(job);
  for (const auto mode : {v1::MaterialConfig::MODE_NONE, v1::MaterialConfig::MODE_ONE_DIFFUSE,
                          v1::MaterialConfig::MODE_METAL_GLASS}) {
    job.mutable_config()->mutable_materials()->set_mode(mode);
    const v1::Scene other = SceneOf(job);
    EXPECT_EQ(ObjectsWithoutMaterials(all), ObjectsWithoutMaterials(other));
    EXPECT_EQ(RigsWithoutBaseline(all), RigsWithoutBaseline(other));
    EXPECT_NE(all.SerializeAsString(), other.SerializeAsString());
  }
}

TEST(Solve, NoMaterialsMeansGreyObjectsInAnUnchangedRoom) {
  v1::SolveJob job = JobOf(6);
  const v1::Scene all = SceneOf(job);
  job.mutable_config()->mutable_materials()->set_mode(v1::MaterialConfig::MODE_NONE);
  const v1::Scene none = SceneOf(job);
  std::map<uint32_t, std::string> class_of, all_class_of;
  for (const auto& m : none.materials())
    class_of[m.index()] = m.material_class() + std::to_string(m.seed());
  for (const auto& m : all.materials())
    all_class_of[m.index()] = m.material_class() + std::to_string(m.seed());
  for (int i = 0; i < none.objects_size(); ++i) {
    for (int k = 0; k < none.objects(i).materials_size(); ++k) {
      const std::string& name = class_of[none.objects(i).materials(k).material_index()];
      if (none.objects(i).role() == v1::OBJECT_ROLE_ARCHITECTURE) {
        EXPECT_EQ(name, all_class_of[all.objects(i).materials(k).material_index()]);
      } else if (none.objects(i).role() == v1::OBJECT_ROLE_FLOATING &&
                 none.objects(i).asset_class().find("Lamp") == std::string::npos) {
        EXPECT_EQ(name.substr(0, 9), "PlainGrey");
      }
    }
  }
}

TEST(Solve, BaselineChangesNothingButTheBaseline) {
  v1::SolveJob job = JobOf(7);
  v1::Scene wide = SceneOf(job);
  auto& uniform = *job.mutable_config()->mutable_rigs()->mutable_baseline_m()->mutable_uniform();
  uniform.set_low(0.04);
  uniform.set_high(0.1);
  v1::Scene narrow = SceneOf(job);
  for (int i = 0; i < wide.rigs_size(); ++i) {
    // Common random numbers: both are the same quantile of their ranges.
    EXPECT_NEAR((wide.rigs(i).baseline_m() - 0.04) / 0.36,
                (narrow.rigs(i).baseline_m() - 0.04) / 0.06, 1e-9);
    wide.mutable_rigs(i)->clear_baseline_m();
    narrow.mutable_rigs(i)->clear_baseline_m();
  }
  EXPECT_EQ(wide.SerializeAsString(), narrow.SerializeAsString());
}

TEST(Solve, MoreFloatingObjectsKeepTheFirstOnes) {
  v1::SolveJob job = JobOf(8);
  job.mutable_config()->mutable_floating()->mutable_count()->set_constant(3);
  const v1::Scene few = SceneOf(job);
  job.mutable_config()->mutable_floating()->mutable_count()->set_constant(8);
  const v1::Scene many = SceneOf(job);
  ASSERT_LT(few.objects_size(), many.objects_size());
  const auto few_objects = ObjectsWithoutMaterials(few),
             many_objects = ObjectsWithoutMaterials(many);
  for (size_t i = 0; i < few_objects.size(); ++i) EXPECT_EQ(few_objects[i], many_objects[i]);
}

TEST(Solve, FurnitureOffKeepsRoomLampsAndSky) {
  v1::SolveJob job = JobOf(9);
  const v1::Scene full = SceneOf(job);
  job.mutable_config()->mutable_furniture()->set_enabled(false);
  const v1::Scene bare = SceneOf(job);
  EXPECT_EQ(full.place().SerializeAsString(), bare.place().SerializeAsString());
  EXPECT_EQ(full.sky().SerializeAsString(), bare.sky().SerializeAsString());
  for (const auto& object : bare.objects()) EXPECT_NE(object.role(), v1::OBJECT_ROLE_FURNITURE);
}

TEST(Solve, AugmentedLightingAddsPointLightsOfTheDrawnTotal) {
  int with_points = 0;
  for (uint64_t seed = 20; seed < 26; ++seed) {
    v1::SolveJob job = JobOf(seed);
    job.mutable_config()->mutable_floating()->mutable_count()->set_constant(0);
    job.mutable_config()->mutable_furniture()->set_enabled(false);
    double total = 0;
    const v1::Scene augmented = SceneOf(job);
    for (const auto& light : augmented.lights()) {
      if (light.kind() != v1::Light::KIND_POINT) continue;
      total += FromProto(light.power_w()).mean();
    }
    if (total > 0) {
      ++with_points;
      EXPECT_GT(total, 249);
      EXPECT_LT(total, 1251);
    }
    job.mutable_config()->mutable_lighting()->set_mode(v1::LightingConfig::MODE_REALISTIC);
    const v1::Scene realistic = SceneOf(job);
    EXPECT_FALSE(realistic.place().house().ceiling_removed());
    for (const auto& light : realistic.lights()) EXPECT_NE(light.kind(), v1::Light::KIND_POINT);
  }
  EXPECT_GT(with_points, 1);
}

TEST(Solve, RoomWithoutFreePlacesIsRejected) {
  v1::SolveJob job = JobOf(3);
  job.mutable_config()->mutable_rigs()->set_min_distance_m(3);
  const v1::SolveResult result = SolveOf(job);
  EXPECT_TRUE(result.has_rejected());
  EXPECT_TRUE(result.has_layout()) << "others can still share it";
}

TEST(Solve, ConfigWithoutRigsIsAnInvalidArgument) {
  v1::SolveJob job = JobOf(3);
  job.mutable_config()->clear_rigs();
  EXPECT_EQ(Solve(job, CancelToken()).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(Solve, UnknownNamesAreInvalidArguments) {
  v1::SolveJob job = JobOf(3);
  job.mutable_config()->mutable_floating()->add_classes("Chiar");
  EXPECT_EQ(Solve(job, CancelToken()).status().code(), absl::StatusCode::kInvalidArgument);
  job = JobOf(3);
  job.mutable_config()->mutable_materials()->set_mode(v1::MaterialConfig::MODE_ONE_DIFFUSE);
  job.mutable_config()->mutable_materials()->set_diffuse_material("Woood");
  EXPECT_EQ(Solve(job, CancelToken()).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(Solve, EveryFamilyThatAnAssetNamesHasMaterials) {
  for (const AssetClass& asset_class : AssetCatalogue()) {
    for (uint64_t seed = 0; seed < 3; ++seed) {
      const Asset asset = MakeAsset(asset_class.name, seed).value();
      for (const MaterialSlot& slot : asset.mesh.slots) {
        for (const std::string& family : slot.families) {
          EXPECT_FALSE(MaterialsOfFamily(family).empty())
              << asset_class.name << "." << slot.name << ": " << family;
        }
      }
    }
  }
}

TEST(SceneGeometry, BrokenRecipesNameTheObject) {
  v1::Scene scene = SceneOf(JobOf(2));
  v1::Scene broken = scene;
  broken.mutable_objects(0)->mutable_materials(0)->set_material_index(9999);
  const absl::Status status = BuildSceneGeometry(broken).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(std::string(status.message()).find(scene.objects(0).name()), std::string::npos);
  broken = scene;
  broken.mutable_objects(0)->set_part("moat");
  EXPECT_EQ(BuildSceneGeometry(broken).status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace parallax
