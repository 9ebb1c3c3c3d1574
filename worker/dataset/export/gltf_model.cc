#include "worker/dataset/export/gltf_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace parallax {
namespace {

constexpr char kInstancing[] = "EXT_mesh_gpu_instancing";

void AddOnce(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

}  // namespace

GltfModel::GltfModel() {
  model_.buffers.emplace_back();
  tinygltf::Node root;
  root.name = "z_up";
  root.rotation = {-std::numbers::sqrt2 / 2, 0, 0, std::numbers::sqrt2 / 2};
  model_.nodes.push_back(root);
}

void GltfModel::AddNode(tinygltf::Node node) {
  model_.nodes[0].children.push_back(static_cast<int>(model_.nodes.size()));
  model_.nodes.push_back(std::move(node));
}

int GltfModel::AddMesh(const std::string& name, const Mesh& mesh,
                       const std::vector<uint32_t>& material_of_slot,
                       const std::map<uint32_t, int>& materials) {
  const Vertices& vertices = VerticesOf(mesh);
  tinygltf::Mesh made;
  made.name = name;
  for (const auto& [slot, indices] : vertices.indices) {
    tinygltf::Primitive primitive;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    primitive.attributes = {{"POSITION", vertices.positions}, {"NORMAL", vertices.normals}};
    primitive.indices = indices;
    const uint32_t bound = slot < material_of_slot.size() ? material_of_slot[slot] : 0;
    const auto material = materials.find(bound);
    if (material != materials.end()) primitive.material = material->second;
    made.primitives.push_back(std::move(primitive));
  }
  model_.meshes.push_back(std::move(made));
  return static_cast<int>(model_.meshes.size()) - 1;
}

void GltfModel::SetColors(int mesh, const std::vector<Vec3f>& colors) {
  const int accessor = AddVertexVectors(colors);
  for (auto& primitive : model_.meshes[static_cast<size_t>(mesh)].primitives) {
    primitive.attributes["COLOR_0"] = accessor;
  }
}

void GltfModel::AddInstances(const std::string& name, int mesh,
                             const std::vector<const Instance*>& instances) {
  std::vector<float> translations, rotations, scales, objects;
  for (const Instance* instance : instances) {
    const auto& place = instance->world_from_object;
    const float scale = std::cbrt(place.leftCols<3>().determinant());
    const Eigen::Quaternionf turn(Mat3f(place.leftCols<3>() / scale));
    for (int i = 0; i < 3; ++i) translations.push_back(place(i, 3));
    for (int i = 0; i < 4; ++i) rotations.push_back(turn.coeffs()[i]);  // x, y, z, w.
    scales.insert(scales.end(), 3, scale);
    objects.push_back(static_cast<float>(instance->object_index));  // Exact below 2^24.
  }
  tinygltf::Value::Object attributes;
  const auto add = [&](const char* attribute, const std::vector<float>& data, size_t floats_each) {
    attributes.emplace(attribute,
                       tinygltf::Value(AddFloats(data.data(), instances.size(), floats_each, 0)));
  };
  add("TRANSLATION", translations, 3);
  add("ROTATION", rotations, 4);
  add("SCALE", scales, 3);
  add("_OBJECT_INDEX", objects, 1);
  tinygltf::Value::Object extension;
  extension.emplace("attributes", tinygltf::Value(attributes));
  tinygltf::Node node;
  node.name = name;
  node.mesh = mesh;
  node.extensions[kInstancing] = tinygltf::Value(extension);
  Use(kInstancing, /*required=*/true);
  AddNode(std::move(node));
}

void GltfModel::Use(const std::string& extension, bool required) {
  AddOnce(model_.extensionsUsed, extension);
  if (required) AddOnce(model_.extensionsRequired, extension);
}

const GltfModel::Vertices& GltfModel::VerticesOf(const Mesh& mesh) {
  const auto [entry, added] = vertices_.try_emplace(&mesh);
  Vertices& made = entry->second;
  if (!added) return made;
  made.positions = AddVertexVectors(mesh.positions);
  const Box3f bounds = mesh.Bounds();
  auto& accessor = model_.accessors[static_cast<size_t>(made.positions)];
  for (int i = 0; i < 3; ++i) {
    accessor.minValues.push_back(double{bounds.min()[i]});
    accessor.maxValues.push_back(double{bounds.max()[i]});
  }
  made.normals = AddVertexVectors(mesh.normals);
  triangles_ += static_cast<int64_t>(mesh.triangles.size());
  std::map<uint16_t, std::vector<uint32_t>> by_slot;
  for (const Triangle& t : mesh.triangles) {
    for (const uint32_t vertex : {t.a, t.b, t.c}) by_slot[t.slot].push_back(vertex);
  }
  for (const auto& [slot, indices] : by_slot) {
    made.indices[slot] = AddAccessor(indices.data(), indices.size(), sizeof(uint32_t),
                                     TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR,
                                     TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
  }
  return made;
}

int GltfModel::AddAccessor(const void* data, size_t count, size_t bytes_each, int component,
                           int type, int target) {
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

int GltfModel::AddVertexVectors(const std::vector<Vec3f>& vectors) {
  static_assert(sizeof(Vec3f) == 12);
  return AddFloats(vectors.data()->data(), vectors.size(), 3, TINYGLTF_TARGET_ARRAY_BUFFER);
}

int GltfModel::AddFloats(const float* data, size_t count, size_t floats_each, int target) {
  // glTF's vectors of 1 to 4 numbers.
  constexpr int kTypes[] = {TINYGLTF_TYPE_SCALAR, TINYGLTF_TYPE_VEC2, TINYGLTF_TYPE_VEC3,
                            TINYGLTF_TYPE_VEC4};
  return AddAccessor(data, count, floats_each * sizeof(float), TINYGLTF_COMPONENT_TYPE_FLOAT,
                     kTypes[floats_each - 1], target);
}

}  // namespace parallax
