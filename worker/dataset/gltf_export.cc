#include "worker/dataset/gltf_export.h"

#include <fmt/core.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <sstream>

#include "common/base/file.h"
#include "common/base/version.h"
#include "common/math/stereo.h"
#include "worker/render/sky.h"
#include "worker/scene/scene_geometry.h"

namespace parallax {
namespace {

constexpr char kLights[] = "KHR_lights_punctual";
constexpr char kTransmission[] = "KHR_materials_transmission";
// Lumens of a radiant watt as glTF exporters count it: candela = W / (4 pi) * 683.
constexpr double kLumensPerWatt = 683.0;
constexpr int kSamples = 96;  // Points of a material's surfaces that its constant values average.

tinygltf::Value NumberObject(const char* key, double value) {
  tinygltf::Value::Object object;
  object.emplace(key, tinygltf::Value(value));
  return tinygltf::Value(object);
}

// Column-major, as glTF stores matrices.
std::vector<double> MatrixOf(const Eigen::Affine3d& transform) {
  const Eigen::Matrix4d matrix = transform.matrix();
  return {matrix.data(), matrix.data() + 16};
}

// The average look of the surfaces that carry a material.
struct AverageSurface {
  Vec3d color = Vec3d::Zero(), emission = Vec3d::Zero();
  double metallic = 0, roughness = 0, transmission = 0, opacity = 0;
  int count = 0;

  void Add(const SurfaceSample& sample) {
    color += sample.base_color.cast<double>();
    emission += sample.emission.cast<double>();
    metallic += sample.metallic;
    roughness += sample.roughness;
    transmission += sample.transmission;
    opacity += sample.opacity;
    ++count;
  }
};

class GltfBuilder {
 public:
  GltfBuilder(const v1::Scene& scene, const SceneGeometry& geometry)
      : scene_(scene), geometry_(geometry) {}

  tinygltf::Model Build() {
    model_.asset.version = "2.0";
    model_.asset.generator = std::string("Parallax ") + kProgramVersion;
    model_.buffers.emplace_back();
    // Nodes hang from one that turns z up into glTF's y up.
    tinygltf::Node root;
    root.name = "z_up";
    root.rotation = {-std::numbers::sqrt2 / 2, 0, 0, std::numbers::sqrt2 / 2};
    model_.nodes.push_back(root);
    AddMaterials();
    AddObjects();
    AddLights();
    AddCameras();
    tinygltf::Scene scene;
    scene.name = "scene";
    scene.nodes = {0};
    model_.scenes.push_back(scene);
    model_.defaultScene = 0;
    return std::move(model_);
  }

 private:
  // Averages over evenly spread corners of the triangles that carry each material.
  std::map<uint32_t, AverageSurface> AverageSurfaces() const {
    std::map<uint32_t, std::vector<SurfacePoint>> points;
    for (const PlacedMesh& placed : geometry_.meshes) {
      const Mesh& mesh = *placed.mesh;
      const float scale = std::cbrt(std::abs(placed.world_from_object.linear().determinant()));
      const size_t step = std::max<size_t>(1, mesh.triangles.size() / kSamples);
      for (size_t i = 0; i < mesh.triangles.size(); i += step) {
        const Triangle& triangle = mesh.triangles[i];
        if (triangle.slot >= placed.material_of_slot.size()) continue;
        SurfacePoint point;
        point.texture_m = mesh.texture[triangle.a] * scale;
        point.normal = mesh.normals[triangle.a];
        point.uv = mesh.uv.empty() ? Vec2f::Zero() : mesh.uv[triangle.a];
        points[placed.material_of_slot[triangle.slot]].push_back(point);
      }
    }
    std::map<uint32_t, AverageSurface> surfaces;
    for (const auto& [index, all] : points) {
      if (index >= geometry_.materials.size() || geometry_.materials[index] == nullptr) continue;
      const size_t step = std::max<size_t>(1, all.size() / kSamples);
      for (size_t i = 0; i < all.size(); i += step) {
        surfaces[index].Add(geometry_.materials[index]->Evaluate(all[i]));
      }
    }
    return surfaces;
  }

  void AddMaterials() {
    const std::map<uint32_t, AverageSurface> surfaces = AverageSurfaces();
    for (const v1::SceneMaterial& material : scene_.materials()) {
      const auto found = surfaces.find(material.index());
      AverageSurface average = found != surfaces.end() ? found->second : AverageSurface();
      if (average.count == 0) average.Add(SurfaceSample());
      const double n = average.count;
      Vec3d color = average.color / n;
      if (material.has_tint()) color = color.cwiseProduct(FromProto(material.tint()));
      color = color.cwiseMax(0.0).cwiseMin(1.0);
      tinygltf::Material out;
      out.name = material.name();
      auto& pbr = out.pbrMetallicRoughness;
      const double opacity = average.opacity / n;
      pbr.baseColorFactor = {color.x(), color.y(), color.z(), opacity};
      pbr.metallicFactor = std::clamp(average.metallic / n, 0.0, 1.0);
      pbr.roughnessFactor = std::clamp(average.roughness / n, 0.0, 1.0);
      out.doubleSided = true;
      if (opacity < 0.99) out.alphaMode = "BLEND";
      const Vec3d emission = average.emission / n;
      if (emission.maxCoeff() > 0) {
        const Vec3d factor = emission / std::max(1.0, emission.maxCoeff());
        out.emissiveFactor = {factor.x(), factor.y(), factor.z()};
      }
      const double transmission = average.transmission / n;
      if (transmission > 0.01) {
        out.extensions[kTransmission] = NumberObject("transmissionFactor", transmission);
        Use(kTransmission);
      }
      material_index_[material.index()] = static_cast<int>(model_.materials.size());
      model_.materials.push_back(std::move(out));
    }
  }

  int AddAccessor(const void* data, size_t count, size_t bytes_each, int component, int type,
                  int target) {
    std::vector<unsigned char>& buffer = model_.buffers[0].data;
    while (buffer.size() % 4 != 0) buffer.push_back(0);
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = buffer.size();
    view.byteLength = count * bytes_each;
    view.target = target;
    const auto* bytes = static_cast<const unsigned char*>(data);
    buffer.insert(buffer.end(), bytes, bytes + view.byteLength);
    model_.bufferViews.push_back(view);
    tinygltf::Accessor accessor;
    accessor.bufferView = static_cast<int>(model_.bufferViews.size()) - 1;
    accessor.componentType = component;
    accessor.count = count;
    accessor.type = type;
    model_.accessors.push_back(accessor);
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  int AddVectors(const std::vector<Vec3f>& vectors) {
    static_assert(sizeof(Vec3f) == 12);
    return AddAccessor(vectors.data(), vectors.size(), sizeof(Vec3f), TINYGLTF_COMPONENT_TYPE_FLOAT,
                       TINYGLTF_TYPE_VEC3, TINYGLTF_TARGET_ARRAY_BUFFER);
  }

  // Accessors of a mesh: shared by all objects of equal class and seed.
  struct MeshData {
    int positions = -1, normals = -1;
    std::map<uint16_t, int> indices;  // By slot.
  };
  const MeshData& DataOf(const Mesh& mesh) {
    const auto [entry, added] = mesh_data_.try_emplace(&mesh);
    MeshData& data = entry->second;
    if (!added) return data;
    data.positions = AddVectors(mesh.positions);
    const Box3f bounds = mesh.Bounds();
    auto& accessor = model_.accessors[static_cast<size_t>(data.positions)];
    for (int i = 0; i < 3; ++i) {
      accessor.minValues.push_back(double{bounds.min()[i]});
      accessor.maxValues.push_back(double{bounds.max()[i]});
    }
    data.normals = AddVectors(mesh.normals);
    std::map<uint16_t, std::vector<uint32_t>> by_slot;
    for (const Triangle& t : mesh.triangles) {
      for (const uint32_t vertex : {t.a, t.b, t.c}) by_slot[t.slot].push_back(vertex);
    }
    for (const auto& [slot, indices] : by_slot) {
      data.indices[slot] = AddAccessor(indices.data(), indices.size(), sizeof(uint32_t),
                                       TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR,
                                       TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    }
    return data;
  }

  void AddObjects() {
    std::map<uint32_t, std::string> names;
    for (const v1::SceneObject& object : scene_.objects()) names[object.index()] = object.name();
    for (const PlacedMesh& placed : geometry_.meshes) {
      if (placed.mesh == nullptr || placed.mesh->triangles.empty()) continue;
      const MeshData& data = DataOf(*placed.mesh);
      tinygltf::Mesh mesh;
      mesh.name = names[placed.object_index];
      for (const auto& [slot, indices] : data.indices) {
        tinygltf::Primitive primitive;
        primitive.mode = TINYGLTF_MODE_TRIANGLES;
        primitive.attributes = {{"POSITION", data.positions}, {"NORMAL", data.normals}};
        primitive.indices = indices;
        const uint32_t bound =
            slot < placed.material_of_slot.size() ? placed.material_of_slot[slot] : 0;
        const auto material = material_index_.find(bound);
        if (material != material_index_.end()) primitive.material = material->second;
        mesh.primitives.push_back(std::move(primitive));
      }
      tinygltf::Node node;
      node.name = mesh.name;
      node.mesh = static_cast<int>(model_.meshes.size());
      node.matrix = MatrixOf(placed.world_from_object.cast<double>());
      model_.meshes.push_back(std::move(mesh));
      AddNode(std::move(node));
    }
  }

  // Middle of the faces that glow, world frame.
  Vec3d EmitterCenter(const v1::Light& light) const {
    for (const PlacedMesh& placed : geometry_.meshes) {
      if (placed.object_index != light.object_index()) continue;
      Vec3f sum = Vec3f::Zero();
      int count = 0;
      for (const Triangle& t : placed.mesh->triangles) {
        if (placed.mesh->slots[t.slot].name != light.slot()) continue;
        sum += placed.mesh->positions[t.a];
        ++count;
      }
      const Vec3f center =
          count > 0 ? Vec3f(sum / static_cast<float>(count)) : Vec3f(Vec3f::Zero());
      return (placed.world_from_object * center).cast<double>();
    }
    return FromProto(light.position_m());
  }

  int AddLight(const std::string& name, const std::string& type, const Vec3d& color,
               double intensity) {
    tinygltf::Light light;
    light.name = name;
    light.type = type;
    light.color = {color.x(), color.y(), color.z()};
    light.intensity = intensity;
    model_.lights.push_back(std::move(light));
    Use(kLights);
    return static_cast<int>(model_.lights.size()) - 1;
  }

  void AddLightNode(const std::string& name, int light, tinygltf::Node node) {
    node.name = name;
    tinygltf::Value::Object extension;
    extension.emplace("light", tinygltf::Value(light));
    node.extensions[kLights] = tinygltf::Value(extension);
    AddNode(std::move(node));
  }

  // Shines along its node's -z. glTF's cones end at half a straight angle.
  void AddSpot(const v1::Light& light, const Vec3d& power, tinygltf::Node node) {
    const double outer_cos = std::cos(light.cone_rad());
    const double inner_cos = outer_cos + std::clamp(light.cone_blend(), 0.0, 1.0) * (1 - outer_cos);
    const double solid_angle = 2 * std::numbers::pi * (1 - 0.5 * (outer_cos + inner_cos));
    const double most = power.maxCoeff();
    const auto turn =
        Eigen::Quaterniond::FromTwoVectors(-Vec3d::UnitZ(), FromProto(light.direction()));
    node.rotation = {turn.x(), turn.y(), turn.z(), turn.w()};
    const int index =
        AddLight(light.name(), "spot", power / most, most / solid_angle * kLumensPerWatt);
    tinygltf::SpotLight& spot = model_.lights[static_cast<size_t>(index)].spot;
    spot.outerConeAngle = std::min(light.cone_rad(), 0.5 * std::numbers::pi);
    spot.innerConeAngle = std::min(std::acos(std::min(inner_cos, 1.0)), spot.outerConeAngle);
    AddLightNode(light.name(), index, std::move(node));
  }

  void AddLights() {
    for (const v1::Light& light : scene_.lights()) {
      const Vec3d power = FromProto(light.power_w());
      const double most = power.maxCoeff();
      if (most <= 0) continue;
      const Vec3d position = light.kind() == v1::Light::KIND_MESH ? EmitterCenter(light)
                                                                  : FromProto(light.position_m());
      tinygltf::Node node;
      node.translation = {position.x(), position.y(), position.z()};
      if (light.kind() == v1::Light::KIND_SPOT) {
        AddSpot(light, power, std::move(node));
        continue;
      }
      AddLightNode(light.name(),
                   AddLight(light.name(), "point", power / most,
                            most / (4 * std::numbers::pi) * kLumensPerWatt),
                   std::move(node));
    }
    const SkyModel sky(scene_.sky());
    if (!sky.has_sun()) return;
    // A directional light shines along its node's -z: from the sun down to the ground.
    const Vec3d irradiance = (sky.SunRadiance() * sky.sun_solid_angle()).cast<double>();
    const double most = irradiance.maxCoeff();
    const auto turn =
        Eigen::Quaterniond::FromTwoVectors(Vec3d::UnitZ(), sky.sun_direction().cast<double>());
    tinygltf::Node node;
    node.rotation = {turn.x(), turn.y(), turn.z(), turn.w()};
    AddLightNode("sun", AddLight("sun", "directional", irradiance / most, most * kLumensPerWatt),
                 std::move(node));
  }

  void AddCameras() {
    for (const v1::Rig& rig : scene_.rigs()) {
      tinygltf::Camera camera;
      camera.type = "perspective";
      camera.perspective.yfov = 2 * std::atan(HalfTangents(rig).y());
      camera.perspective.aspectRatio =
          rig.width_px() * rig.fy_px() / (rig.height_px() * rig.fx_px());
      camera.perspective.znear = 0.01;
      camera.perspective.zfar = 1000;
      camera.name = fmt::format("rig_{:03}", rig.index());
      const int index = static_cast<int>(model_.cameras.size());
      model_.cameras.push_back(camera);
      AddCamera(camera.name + "_left", index, rig, 0);
      AddCamera(camera.name + "_right", index, rig, 1);
    }
  }

  void AddCamera(const std::string& name, int camera, const v1::Rig& rig, int eye) {
    Eigen::Affine3d world_from_camera = Eigen::Affine3d::Identity();
    // glTF's cameras look along -z with y up; ours along +z with y down.
    world_from_camera.linear() = RigAxes(rig) * Eigen::DiagonalMatrix<double, 3>(1, -1, -1);
    world_from_camera.translation() = EyePosition(rig, eye);
    tinygltf::Node node;
    node.name = name;
    node.camera = camera;
    node.matrix = MatrixOf(world_from_camera);
    AddNode(std::move(node));
  }

  void AddNode(tinygltf::Node node) {
    model_.nodes[0].children.push_back(static_cast<int>(model_.nodes.size()));
    model_.nodes.push_back(std::move(node));
  }

  void Use(const std::string& extension) {
    for (const std::string& used : model_.extensionsUsed) {
      if (used == extension) return;
    }
    model_.extensionsUsed.push_back(extension);
  }

  const v1::Scene& scene_;
  const SceneGeometry& geometry_;
  tinygltf::Model model_;
  std::map<uint32_t, int> material_index_;
  std::map<const Mesh*, MeshData> mesh_data_;
};

}  // namespace

absl::Status ExportGltf(const v1::Scene& scene, const std::string& glb_path) {
  ASSIGN_OR_RETURN(const SceneGeometry geometry, BuildSceneGeometry(scene));
  tinygltf::Model model = GltfBuilder(scene, geometry).Build();
  std::ostringstream out;
  tinygltf::TinyGLTF writer;
  if (!writer.WriteGltfSceneToStream(&model, out, /*prettyPrint=*/false, /*writeBinary=*/true)) {
    return Internal("could not encode the scene as glTF");
  }
  return WriteFile(glb_path, out.str());
}

}  // namespace parallax
