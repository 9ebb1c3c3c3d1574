#include "worker/dataset/export/gltf_export.h"

#include <fmt/core.h>
#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <filesystem>

#include "common/config/config.h"
#include "common/math/proto.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/solve_scene.h"

namespace parallax {
namespace {

v1::Scene SceneOf(const std::string& config) {
  v1::SolveJob job;
  *job.mutable_config() = *ParseSceneConfig(config, "test");
  for (uint64_t seed = 3; seed < 20; ++seed) {  // A seed may be rejected.
    job.set_scene_seed(seed);
    const auto result = Solve(job, CancelToken());
    EXPECT_TRUE(result.ok()) << result.status();
    if (result->has_scene()) return result->scene();
  }
  ADD_FAILURE() << "no seed gives a scene";
  return v1::Scene();
}

// One solved scene for all tests of rooms.
const v1::Scene& SolvedScene() {
  static const auto* scene = new v1::Scene(
      SceneOf("floating: {count: 3}\nrigs: {count: 2}\nlighting: {point_lights: 2}\n"));
  return *scene;
}

tinygltf::Model ExportAndLoad(const v1::Scene& scene) {
  const std::string path = ::testing::TempDir() + "gltf_export_" +
                           ::testing::UnitTest::GetInstance()->current_test_info()->name() + ".glb";
  const auto contents = ExportGltf(scene, path);
  EXPECT_TRUE(contents.ok()) << contents.status();
  tinygltf::Model model;
  std::string error, warning;
  EXPECT_TRUE(tinygltf::TinyGLTF().LoadBinaryFromFile(&model, &error, &warning, path)) << error;
  EXPECT_EQ(error, "");
  EXPECT_EQ(warning, "");
  std::filesystem::remove(path);
  return model;
}

const tinygltf::Node* FindNode(const tinygltf::Model& model, const std::string& name) {
  for (const tinygltf::Node& node : model.nodes) {
    if (node.name == name) return &node;
  }
  return nullptr;
}

TEST(GltfExport, LoadsBackWithEveryObjectMaterialLightAndCamera) {
  const v1::Scene& scene = SolvedScene();
  const tinygltf::Model model = ExportAndLoad(scene);
  for (const v1::SceneObject& object : scene.objects()) {
    const tinygltf::Node* node = FindNode(model, object.name());
    ASSERT_NE(node, nullptr) << object.name();
    EXPECT_GE(node->mesh, 0);
  }
  ASSERT_EQ(model.materials.size(), static_cast<size_t>(scene.materials_size()));
  for (int i = 0; i < scene.materials_size(); ++i) {
    EXPECT_EQ(model.materials[static_cast<size_t>(i)].name, scene.materials(i).name());
  }
  EXPECT_EQ(model.cameras.size(), static_cast<size_t>(scene.rigs_size()));
  EXPECT_FALSE(model.lights.empty());
  EXPECT_EQ(model.nodes[0].children.size(), model.nodes.size() - 1);
}

TEST(GltfExport, TrianglesAreThoseOfTheRecipe) {
  const v1::Scene& scene = SolvedScene();
  const tinygltf::Model model = ExportAndLoad(scene);
  const auto geometry = BuildSceneGeometry(scene);
  ASSERT_TRUE(geometry.ok());
  size_t want = 0, got = 0;
  for (const PlacedMesh& placed : geometry->meshes) want += placed.mesh->triangles.size();
  for (const tinygltf::Mesh& mesh : model.meshes) {
    for (const tinygltf::Primitive& primitive : mesh.primitives) {
      EXPECT_GE(primitive.material, 0) << mesh.name;
      const auto& indices = model.accessors[static_cast<size_t>(primitive.indices)];
      const auto& positions =
          model.accessors[static_cast<size_t>(primitive.attributes.at("POSITION"))];
      got += indices.count / 3;
      const auto& view = model.bufferViews[static_cast<size_t>(indices.bufferView)];
      const auto* values =
          reinterpret_cast<const uint32_t*>(model.buffers[0].data.data() + view.byteOffset);
      for (size_t i = 0; i < indices.count; ++i) ASSERT_LT(values[i], positions.count);
    }
  }
  EXPECT_EQ(got, want);
}

// The numbers of an instancing node's attribute.
std::vector<float> InstanceNumbers(const tinygltf::Model& model, const tinygltf::Node& node,
                                   const char* attribute) {
  const tinygltf::Value& extension = node.extensions.at("EXT_mesh_gpu_instancing");
  const int index = extension.Get("attributes").Get(attribute).GetNumberAsInt();
  const tinygltf::Accessor& accessor = model.accessors[static_cast<size_t>(index)];
  const auto& view = model.bufferViews[static_cast<size_t>(accessor.bufferView)];
  const auto* first =
      reinterpret_cast<const float*>(model.buffers[0].data.data() + view.byteOffset);
  return {first, first + view.byteLength / sizeof(float)};
}

TEST(GltfExport, EverythingThatGrowsIsAnInstanceInItsPlace) {
  const v1::Scene scene = SceneOf(
      "type: nature\nrigs: {count: 1}\n"
      "nature: {biomes: {desert: 1}}\n");
  const auto geometry = BuildSceneGeometry(scene);
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  ASSERT_GT(geometry->instances.size(), 1000u);
  const tinygltf::Model model = ExportAndLoad(scene);
  EXPECT_EQ(model.extensionsRequired, std::vector<std::string>{"EXT_mesh_gpu_instancing"});
  size_t instances = 0;
  for (size_t i = 0; i < geometry->prototypes.size(); ++i) {
    const tinygltf::Node* node = FindNode(model, fmt::format("prototype_{:03}", i));
    std::vector<Instance> placed;
    for (const Instance& instance : geometry->instances) {
      if (instance.prototype == i) placed.push_back(instance);
    }
    ASSERT_EQ(node == nullptr, placed.empty()) << i;
    if (node == nullptr) continue;
    for (const auto& primitive : model.meshes[static_cast<size_t>(node->mesh)].primitives) {
      EXPECT_GE(primitive.material, 0) << node->name;
    }
    const std::vector<float> t = InstanceNumbers(model, *node, "TRANSLATION"),
                             r = InstanceNumbers(model, *node, "ROTATION"),
                             s = InstanceNumbers(model, *node, "SCALE"),
                             object = InstanceNumbers(model, *node, "_OBJECT_INDEX");
    ASSERT_EQ(object.size(), placed.size());
    for (size_t k = 0; k < placed.size(); ++k) {
      Eigen::Matrix<float, 3, 4> place;
      place.leftCols<3>() = Eigen::Quaternionf(r[4 * k + 3], r[4 * k], r[4 * k + 1], r[4 * k + 2])
                                .toRotationMatrix() *
                            Eigen::DiagonalMatrix<float, 3>(s[3 * k], s[3 * k + 1], s[3 * k + 2]);
      place.col(3) = Vec3f(t[3 * k], t[3 * k + 1], t[3 * k + 2]);
      const auto& want = placed[k].world_from_object;
      ASSERT_LT((place - want).norm(), 1e-5f * want.leftCols<3>().norm()) << node->name;
      ASSERT_EQ(object[k], static_cast<float>(placed[k].object_index));
    }
    instances += placed.size();
  }
  EXPECT_EQ(instances, geometry->instances.size());

  // The ground has its colours at the vertices, and white materials.
  const tinygltf::Node* ground = FindNode(model, "Ground");
  ASSERT_NE(ground, nullptr);
  for (const auto& primitive : model.meshes[static_cast<size_t>(ground->mesh)].primitives) {
    const auto color = primitive.attributes.find("COLOR_0");
    ASSERT_NE(color, primitive.attributes.end());
    EXPECT_EQ(model.accessors[static_cast<size_t>(color->second)].count,
              geometry->meshes[0].mesh->positions.size());
    const auto& material = model.materials[static_cast<size_t>(primitive.material)];
    EXPECT_EQ(material.pbrMetallicRoughness.baseColorFactor[0], 1);
  }
}

TEST(GltfExport, CamerasLookWhereTheRigsLook) {
  const v1::Scene& scene = SolvedScene();
  const tinygltf::Model model = ExportAndLoad(scene);
  const v1::Rig& rig = scene.rigs(1);
  const Pose world_from_left = FromProto(rig.world_from_left());
  const tinygltf::Node* left = FindNode(model, "rig_001_left");
  const tinygltf::Node* right = FindNode(model, "rig_001_right");
  ASSERT_TRUE(left != nullptr && right != nullptr);
  const auto column = [](const tinygltf::Node& node, size_t i) {
    return Vec3d(node.matrix[4 * i], node.matrix[4 * i + 1], node.matrix[4 * i + 2]);
  };
  EXPECT_LT((column(*left, 3) - world_from_left.translation).norm(), 1e-9);
  EXPECT_LT((-column(*left, 2) - world_from_left.rotation * Vec3d::UnitZ()).norm(), 1e-9);
  EXPECT_LT((-column(*left, 1) - world_from_left.rotation * Vec3d::UnitY()).norm(), 1e-9);
  EXPECT_NEAR((column(*right, 3) - column(*left, 3)).norm(), rig.baseline_m(), 1e-9);
  EXPECT_NEAR((column(*right, 3) - column(*left, 3)).dot(column(*left, 0)), rig.baseline_m(), 1e-9);
  const auto& camera = model.cameras[1].perspective;
  EXPECT_NEAR(std::tan(camera.yfov / 2), rig.height_px() / 2.0 / rig.fy_px(), 1e-9);
  EXPECT_NEAR(camera.aspectRatio, double(rig.width_px()) / rig.height_px(), 1e-9);
}

TEST(GltfExport, SpotsKeepTheirConeAndAxis) {
  v1::Scene scene = SolvedScene();
  v1::Light& light = *scene.add_lights();
  light.set_kind(v1::Light::KIND_SPOT);
  light.set_name("stage");
  *light.mutable_position_m() = ToProto(Vec3d(1, 2, 2.4));
  *light.mutable_direction() = ToProto(Vec3d(0.3, 0.1, -2));
  *light.mutable_power_w() = ToProto(Vec3d::Constant(40));
  light.set_cone_rad(0.5);
  light.set_cone_blend(0.4);
  const tinygltf::Model model = ExportAndLoad(scene);
  const tinygltf::Node* node = FindNode(model, "stage");
  ASSERT_NE(node, nullptr);
  const auto& q = node->rotation;
  const Vec3d shines = Eigen::Quaterniond(q[3], q[0], q[1], q[2]) * -Vec3d::UnitZ();
  EXPECT_LT((shines - Vec3d(0.3, 0.1, -2).normalized()).norm(), 1e-9);
  const auto found = std::find_if(model.lights.begin(), model.lights.end(),
                                  [](const tinygltf::Light& l) { return l.name == "stage"; });
  ASSERT_NE(found, model.lights.end());
  EXPECT_EQ(found->type, "spot");
  EXPECT_NEAR(found->spot.outerConeAngle, 0.5, 1e-9);
  EXPECT_NEAR(std::cos(found->spot.innerConeAngle), std::cos(0.5) + 0.4 * (1 - std::cos(0.5)),
              1e-9);
}

TEST(GltfExport, WhatCannotBeWrittenIsAnError) {
  EXPECT_FALSE(ExportGltf(SolvedScene(), "/no/such/folder/a.glb").ok());
  v1::Scene broken = SolvedScene();
  broken.mutable_objects(broken.objects_size() - 1)->set_asset_class("NoSuchThing");
  EXPECT_EQ(ExportGltf(broken, "/tmp/never.glb").status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace parallax
