#include "worker/scene/build_geometry.h"

#include <algorithm>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include "common/base/system/memory_budget.h"
#include "common/math/proto.h"
#include "worker/assets/files/own_meshes.h"
#include "worker/materials/pictures/texture_sets.h"
#include "worker/materials/pictures/user_picture.h"
#include "worker/scene/floating/warp.h"
#include "worker/scene/glass_parts.h"
#include "worker/scene/types/scene_types.h"

namespace parallax {
namespace {

// The recipe's tint over another material.
class TintedMaterial final : public Material {
 public:
  TintedMaterial(std::unique_ptr<const Material> inner, const Vec3f& tint)
      : inner_(std::move(inner)), tint_(tint) {}
  SurfaceSample8 Evaluate(const SurfacePoint8& points) const override {
    SurfaceSample8 sample = inner_->Evaluate(points);
    sample.base_color = Tinted(sample.base_color);
    sample.transmitted_color = Tinted(sample.transmitted_color);
    return sample;
  }
  Float8 Height(const SurfacePoint8& points) const override { return inner_->Height(points); }
  Dual8 Relief(const SurfacePoint8& points, const Tangents8& tangents) const override {
    return inner_->Relief(points, tangents);
  }
  float widest_relief_m() const override { return inner_->widest_relief_m(); }

 private:
  Vec3x8 Tinted(const Vec3x8& color) const {
    const Vec3x8 tinted = color * tint_;
    return {Min(tinted.x, 1.0f), Min(tinted.y, 1.0f), Min(tinted.z, 1.0f)};
  }

  std::unique_ptr<const Material> inner_;
  Vec3f tint_;
};

absl::StatusOr<std::unique_ptr<const Material>> MakeListedMaterial(const v1::SceneMaterial& entry) {
  const std::string& name = entry.material_class();
  if (!entry.picture_file().empty()) return MakeUserPicture(entry.picture_file(), entry.seed());
  if (name.starts_with(kOwnPrefix)) return MakeOwnTexture(name, entry.seed());
  if (IsOwnMeshMaterial(name)) return MakeOwnMeshMaterial(name, entry.seed());
  return MakeMaterial(name, entry.seed());
}

// Class and omitted slots, seed, warp's seed, warp.
using MeshKey = std::tuple<std::string, uint64_t, uint64_t, double>;

absl::StatusOr<std::shared_ptr<const Mesh>> MeshOf(
    const v1::Scene& scene, const v1::SceneObject& object,
    std::map<MeshKey, std::shared_ptr<const Mesh>>& made) {
  if (!object.part().empty()) {
    ASSIGN_OR_RETURN(Mesh mesh, MakePart(scene, object));
    return std::make_shared<const Mesh>(std::move(mesh));
  }
  std::string key = object.asset_class();
  for (const std::string& slot : object.omitted_slots()) key += "-" + slot;
  auto& entry = made[{key, object.seed(), object.warp_seed(), object.warp()}];
  if (entry == nullptr) {
    ASSIGN_OR_RETURN(Mesh mesh, MakeObjectMesh(object));
    if (object.omitted_slots_size() > 0) {
      mesh = WithoutSlots(mesh, {object.omitted_slots().begin(), object.omitted_slots().end()});
    }
    entry = std::make_shared<const Mesh>(std::move(mesh));
  }
  return entry;
}

absl::StatusOr<std::vector<uint32_t>> BindSlots(const v1::SceneObject& object, const Mesh& mesh,
                                                const SceneGeometry& geometry) {
  std::vector<uint32_t> bound(mesh.slots.size(), 0);
  for (const v1::MaterialBinding& binding : object.materials()) {
    if (binding.material_index() >= geometry.materials.size() ||
        geometry.materials[binding.material_index()] == nullptr) {
      return InvalidArgument("slot \"{}\" is bound to missing material {}", binding.slot(),
                             binding.material_index());
    }
    for (size_t i = 0; i < mesh.slots.size(); ++i) {
      if (mesh.slots[i].name == binding.slot()) bound[i] = binding.material_index();
    }
  }
  return bound;
}

}  // namespace

absl::StatusOr<SceneGeometry> BuildSceneGeometry(const v1::Scene& scene) {
  ASSIGN_OR_RETURN(const SceneType* type, TypeOf(scene));
  SceneGeometry geometry;
  geometry.surroundings = type->surroundings(scene.place());
  for (const v1::SceneMaterial& entry : scene.materials()) {
    // The values of materials_*.png; a table is as long as its largest index.
    if (entry.index() > 0xffff) {
      return InvalidArgument("material {} has index {}, allowed is at most 65535", entry.name(),
                             entry.index());
    }
    auto material = MakeListedMaterial(entry);
    if (!material.ok()) return WithContext(material.status(), "material " + entry.name());
    if (geometry.materials.size() <= entry.index()) geometry.materials.resize(entry.index() + 1);
    if (entry.has_tint()) {
      geometry.materials[entry.index()] = std::make_shared<TintedMaterial>(
          *std::move(material), FromProto(entry.tint()).cast<float>());
    } else {
      geometry.materials[entry.index()] = *std::move(material);
    }
  }
  if (geometry.materials.empty()) geometry.materials.resize(1);

  std::map<MeshKey, std::shared_ptr<const Mesh>> made;
  for (const v1::SceneObject& object : scene.objects()) {
    if (object.index() > 0xffff) {  // The values of objects_*.png.
      return InvalidArgument("object {} has index {}, allowed is at most 65535", object.name(),
                             object.index());
    }
    PlacedMesh placed;
    auto mesh = MeshOf(scene, object, made);
    if (!mesh.ok()) return WithContext(mesh.status(), "object " + object.name());
    auto slots = BindSlots(object, **mesh, geometry);
    if (!slots.ok()) return WithContext(slots.status(), "object " + object.name());
    RETURN_IF_ERROR(CheckMemory("scene: meshes up to object " + object.name(), 0));
    placed.mesh = *std::move(mesh);
    placed.material_of_slot = *std::move(slots);
    placed.world_from_object = FromProto(object.world_from_object()).Affine();
    placed.object_index = object.index();
    geometry.meshes.push_back(std::move(placed));
  }
  if (type->expand) RETURN_IF_ERROR(type->expand(scene, geometry));
  return geometry;
}

}  // namespace parallax
