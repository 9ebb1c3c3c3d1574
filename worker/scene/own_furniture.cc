#include "worker/scene/own_furniture.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "common/base/rng.h"
#include "common/math/proto.h"

namespace parallax {
namespace {

// Objects on which others stand, or which give light.
std::set<uint32_t> BusyObjects(const v1::Scene& recipe) {
  std::set<uint32_t> busy;
  for (const v1::SceneObject& object : recipe.objects()) busy.insert(object.parent_index());
  for (const v1::Light& light : recipe.lights()) {
    if (light.kind() == v1::Light::KIND_MESH) busy.insert(light.object_index());
  }
  return busy;
}

// The pose that maps the box of `own` into the replaced object's box.
Pose FittedInto(const Box3f& box, const Box3f& own, bool on_wall) {
  const Vec3d size = box.diagonal().cast<double>(), own_size = own.diagonal().cast<double>();
  Pose pose;
  pose.scale = 1e9;
  for (int axis = 0; axis < 3; ++axis) {
    if (own_size[axis] > 1e-9) pose.scale = std::min(pose.scale, size[axis] / own_size[axis]);
  }
  const Vec3d middle = box.center().cast<double>(), own_middle = own.center().cast<double>();
  pose.translation = middle - pose.scale * own_middle;
  const auto touch = [&](int axis) {
    pose.translation[axis] = double{box.min()[axis]} - pose.scale * double{own.min()[axis]};
  };
  if (on_wall) {
    touch(1);
  } else {
    touch(2);
  }
  return pose;
}

}  // namespace

absl::Status PutOwnFurniture(const v1::AssetConfig& config, SceneInProgress& scene) {
  if (scene.own.meshes.empty()) return absl::OkStatus();
  const Rng root(scene.seed, "dress/own furniture");
  const std::set<uint32_t> busy = BusyObjects(scene.recipe);
  for (v1::SceneObject& object : *scene.recipe.mutable_objects()) {
    if (object.role() != v1::OBJECT_ROLE_FURNITURE || !object.part().empty()) continue;
    if (busy.contains(object.index())) continue;
    std::vector<const OwnMesh*> meshes;
    for (const OwnMesh& mesh : scene.own.meshes) {
      if (mesh.asset_class == std::string(kOwnPrefix) + object.asset_class()) {
        meshes.push_back(&mesh);
      }
    }
    const Rng stream = root.Child(object.name());
    if (meshes.empty() || !stream.Child("own").Bernoulli(config.include_p())) continue;
    const OwnMesh& mesh = *stream.Child("mesh").Pick(meshes);
    ASSIGN_OR_RETURN(const PooledAsset* old, scene.pool.Get(object.asset_class(), object.seed()));
    ASSIGN_OR_RETURN(const PooledAsset* own, scene.pool.Get(mesh.asset_class, mesh.seed));
    const bool on_wall = object.relation() == "on_wall";
    const Pose fitted = FittedInto(old->bounds, own->bounds, on_wall);
    *object.mutable_world_from_object() = ToProto(FromProto(object.world_from_object()) * fitted);
    object.set_asset_class(mesh.asset_class);
    object.set_seed(mesh.seed);
  }
  return absl::OkStatus();
}

}  // namespace parallax
