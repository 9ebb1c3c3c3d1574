#include "worker/dataset/export/gltf_export.h"

#include <fmt/core.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <set>
#include <sstream>

#include "common/base/system/file.h"
#include "common/base/version.h"
#include "common/math/stereo.h"
#include "worker/dataset/export/gltf_model.h"
#include "worker/render/lights/sky.h"
#include "worker/scene/build_geometry.h"

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
    gltf().asset.version = "2.0";
    gltf().asset.generator = std::string("Parallax ") + kProgramVersion;
    AddMaterials();
    AddObjects();
    AddInstances();
    AddLights();
    AddCameras();
    contents_.triangles = model_.triangles();
    tinygltf::Scene scene;
    scene.name = "scene";
    scene.nodes = {0};
    gltf().scenes.push_back(scene);
    gltf().defaultScene = 0;
    return std::move(gltf());
  }

  const GltfContents& contents() const { return contents_; }

 private:
  tinygltf::Model& gltf() { return model_.model(); }

  // Adds evenly spread corners of a mesh's triangles, by material.
  static void AddPoints(const Mesh& mesh, const std::vector<uint32_t>& material_of_slot,
                        float scale, std::map<uint32_t, std::vector<SurfacePoint>>& points) {
    const size_t step = std::max<size_t>(1, mesh.triangles.size() / kSamples);
    for (size_t i = 0; i < mesh.triangles.size(); i += step) {
      const Triangle& triangle = mesh.triangles[i];
      if (triangle.slot >= material_of_slot.size()) continue;
      SurfacePoint point;
      point.texture_m = mesh.texture[triangle.a] * scale;
      point.normal = mesh.normals[triangle.a];
      point.uv = mesh.uv.empty() ? Vec2f::Zero() : mesh.uv[triangle.a];
      points[material_of_slot[triangle.slot]].push_back(point);
    }
  }

  // Averages over evenly spread corners of the triangles that carry each material.
  std::map<uint32_t, AverageSurface> AverageSurfaces() const {
    std::map<uint32_t, std::vector<SurfacePoint>> points;
    for (const PlacedMesh& placed : geometry_.meshes) {
      const float scale = std::cbrt(std::abs(placed.world_from_object.linear().determinant()));
      AddPoints(*placed.mesh, placed.material_of_slot, scale, points);
    }
    for (const Prototype& prototype : geometry_.prototypes) {
      AddPoints(*prototype.mesh, prototype.material_of_slot, 1, points);
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

  // Whether the object's colours are given at its vertices: a landscape's patterns are wider than
  // its triangles.
  bool IsGround(const PlacedMesh& placed) const {
    for (const v1::SceneObject& object : scene_.objects()) {
      if (object.index() == placed.object_index) return object.role() == v1::OBJECT_ROLE_TERRAIN;
    }
    return false;
  }

  // Base colours at a mesh's vertices, averaged over the width of their triangles.
  std::vector<Vec3f> VertexColors(const PlacedMesh& placed) const {
    const Mesh& mesh = *placed.mesh;
    std::vector<Vec3f> colors(mesh.positions.size(), Vec3f::Ones());
    std::vector<bool> done(colors.size());
    for (const Triangle& triangle : mesh.triangles) {
      if (triangle.slot >= placed.material_of_slot.size()) continue;
      const Material* material = geometry_.materials[placed.material_of_slot[triangle.slot]].get();
      if (material == nullptr) continue;
      const float width_m = (mesh.positions[triangle.b] - mesh.positions[triangle.a]).norm();
      for (const uint32_t vertex : {triangle.a, triangle.b, triangle.c}) {
        if (done[vertex]) continue;
        done[vertex] = true;
        SurfacePoint point;
        point.texture_m = mesh.texture[vertex];
        point.normal = mesh.normals[vertex];
        point.footprint_m = width_m;
        colors[vertex] = material->Evaluate(point).base_color.cwiseMax(0.0f).cwiseMin(1.0f);
      }
    }
    return colors;
  }

  void AddMaterials() {
    const std::map<uint32_t, AverageSurface> surfaces = AverageSurfaces();
    std::set<uint32_t> at_vertices;
    for (const PlacedMesh& placed : geometry_.meshes) {
      if (!IsGround(placed)) continue;
      at_vertices.insert(placed.material_of_slot.begin(), placed.material_of_slot.end());
    }
    for (const v1::SceneMaterial& material : scene_.materials()) {
      const auto found = surfaces.find(material.index());
      AverageSurface average = found != surfaces.end() ? found->second : AverageSurface();
      if (average.count == 0) average.Add(SurfaceSample());
      const double n = average.count;
      Vec3d color = average.color / n;
      if (material.has_tint()) color = color.cwiseProduct(FromProto(material.tint()));
      color = color.cwiseMax(0.0).cwiseMin(1.0);
      if (at_vertices.contains(material.index())) color = Vec3d::Ones();
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
        model_.Use(kTransmission);
      }
      material_index_[material.index()] = static_cast<int>(gltf().materials.size());
      gltf().materials.push_back(std::move(out));
    }
  }

  void AddObjects() {
    std::map<uint32_t, std::string> names;
    for (const v1::SceneObject& object : scene_.objects()) names[object.index()] = object.name();
    for (const PlacedMesh& placed : geometry_.meshes) {
      if (placed.mesh == nullptr || placed.mesh->triangles.empty()) continue;
      tinygltf::Node node;
      node.name = names[placed.object_index];
      node.mesh = model_.AddMesh(node.name, *placed.mesh, placed.material_of_slot, material_index_);
      if (IsGround(placed)) model_.SetColors(node.mesh, VertexColors(placed));
      node.matrix = MatrixOf(placed.world_from_object.cast<double>());
      model_.AddNode(std::move(node));
    }
  }

  // One node for each prototype that stands somewhere.
  void AddInstances() {
    std::vector<std::vector<const Instance*>> of_prototype(geometry_.prototypes.size());
    for (const Instance& instance : geometry_.instances) {
      of_prototype[instance.prototype].push_back(&instance);
    }
    for (size_t i = 0; i < of_prototype.size(); ++i) {
      const Prototype& prototype = geometry_.prototypes[i];
      if (of_prototype[i].empty() || prototype.mesh->triangles.empty()) continue;
      const std::string name = fmt::format("prototype_{:03}", i);
      const int mesh =
          model_.AddMesh(name, *prototype.mesh, prototype.material_of_slot, material_index_);
      model_.AddInstances(name, mesh, of_prototype[i]);
      ++contents_.prototypes;
      contents_.instances += static_cast<int64_t>(of_prototype[i].size());
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
    gltf().lights.push_back(std::move(light));
    model_.Use(kLights);
    return static_cast<int>(gltf().lights.size()) - 1;
  }

  void AddLightNode(const std::string& name, int light, tinygltf::Node node) {
    node.name = name;
    tinygltf::Value::Object extension;
    extension.emplace("light", tinygltf::Value(light));
    node.extensions[kLights] = tinygltf::Value(extension);
    model_.AddNode(std::move(node));
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
    tinygltf::SpotLight& spot = gltf().lights[static_cast<size_t>(index)].spot;
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
      camera.name = fmt::format("rig_{:03}", rig.index());
      const int index = static_cast<int>(gltf().cameras.size());
      gltf().cameras.push_back(camera);
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
    model_.AddNode(std::move(node));
  }

  const v1::Scene& scene_;
  const SceneGeometry& geometry_;
  GltfModel model_;
  GltfContents contents_;
  std::map<uint32_t, int> material_index_;
};

}  // namespace

absl::StatusOr<GltfContents> ExportGltf(const v1::Scene& scene, const std::string& glb_path) {
  ASSIGN_OR_RETURN(const SceneGeometry geometry, BuildSceneGeometry(scene));
  GltfBuilder builder(scene, geometry);
  tinygltf::Model model = builder.Build();
  std::ostringstream out;
  tinygltf::TinyGLTF writer;
  if (!writer.WriteGltfSceneToStream(&model, out, /*prettyPrint=*/false, /*writeBinary=*/true)) {
    return Internal("could not encode the scene as glTF");
  }
  RETURN_IF_ERROR(WriteFile(glb_path, out.str()));
  return builder.contents();
}

}  // namespace parallax
