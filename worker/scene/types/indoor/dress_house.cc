#include "worker/scene/types/indoor/dress_house.h"

#include <algorithm>
#include <set>

#include "common/math/proto.h"
#include "worker/layout/plan/room_shell.h"
#include "worker/scene/choose_materials.h"
#include "worker/scene/glass_parts.h"
#include "worker/scene/own_furniture.h"
#include "worker/scene/rigs/best_spread.h"
#include "worker/scene/rigs/room_path.h"
#include "worker/scene/types/indoor/house_materials.h"
#include "worker/scene/types/indoor/landscape.h"

namespace parallax {
namespace {

constexpr uint32_t kMostFloating = 1000;  // More than floating.count may be.
constexpr double kViewOut_m = 9;          // A landscape's depth where rigs are chosen.

// The box that stands for a small thing of another room: nothing comes near it.
Mesh MeshOfBox(const Box3f& box) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.push_back(box.corner(static_cast<Box3f::CornerType>(i)));
  }
  constexpr uint32_t kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                     {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& f : kFaces) {
    mesh.triangles.push_back({f[0], f[1], f[2], 0});
    mesh.triangles.push_back({f[0], f[2], f[3], 0});
  }
  return mesh;
}

// The solid twin of all objects, committed.
absl::Status MakeSolid(SceneInProgress& scene) {
  const v1::House& house = scene.recipe.place().house();
  scene.solid = RayScene();
  for (const v1::SceneObject& object : scene.recipe.objects()) {
    const Eigen::Affine3f place = FromProto(object.world_from_object()).Affine();
    if (!object.part().empty()) {
      auto mesh = MakeRoomPart(house, object);
      if (!mesh.ok()) return WithContext(mesh.status(), "object " + object.name());
      scene.solid.Add(*mesh, place);
    } else {
      auto asset = scene.pool.Get(object.asset_class(), object.seed());
      if (!asset.ok()) return WithContext(asset.status(), "object " + object.name());
      if (RoomIndexOf(house, object.index()) > 0 && object.relation() == "on_top_of") {
        scene.solid.Add(MeshOfBox((*asset)->bounds), place);
      } else {
        scene.solid.Add((*asset)->Tree(), place);
      }
    }
  }
  scene.solid.Commit();
  return absl::OkStatus();
}

// The study's "no background objects": furniture and what stands on it, lamps included.
bool IsFurniture(const v1::SceneObject& object) {
  return object.role() == v1::OBJECT_ROLE_FURNITURE;
}

void RemoveFurniture(v1::Scene& recipe) {
  RemoveObjects(IsFurniture, recipe);
  // Rooms list only what is there.
  std::set<uint32_t> there;
  for (const v1::SceneObject& object : recipe.objects()) there.insert(object.index());
  for (v1::Room& room : *recipe.mutable_place()->mutable_house()->mutable_rooms()) {
    auto& own = *room.mutable_object_index();
    own.erase(std::remove_if(own.begin(), own.end(),
                             [&](uint32_t index) { return !there.contains(index); }),
              own.end());
  }
}

// A removed ceiling takes what hangs from it along.
bool GoesWithTheCeiling(const v1::House& house, const v1::SceneObject& object) {
  const bool above =
      object.part() == "ceiling" || object.part() == "cornice" || object.relation() == "on_ceiling";
  return above && RoomIndexOf(house, object.index()) == 0;
}

uint32_t NextIndex(const v1::Scene& recipe) {
  uint32_t next = 1;
  for (const v1::SceneObject& object : recipe.objects()) next = std::max(next, object.index() + 1);
  return next;
}

absl::Status Stop(const CancelToken& cancel) {
  return cancel.cancelled() ? Cancelled("solve: cancelled") : absl::OkStatus();
}

}  // namespace

absl::Status PlaceHouseRigs(const v1::SceneConfig& config, const CancelToken& cancel,
                            SceneInProgress& scene) {
  RETURN_IF_ERROR(PutOwnFurniture(config.assets(), scene));
  RETURN_IF_ERROR(MakeSolid(scene));
  RETURN_IF_ERROR(Stop(cancel));
  if (StandsInLandscape(config.room(), scene.seed)) scene.view_out_m = kViewOut_m;
  if (config.rigs().path().paths() > 0) {
    RoomPathRigs(config.rigs(), cancel, scene);
  } else {
    BestSpreadRigs(config.rigs(), scene);
  }
  return Stop(cancel);
}

absl::Status DressHouse(const v1::SceneConfig& config, const CancelToken& cancel,
                        SceneInProgress& scene) {
  v1::Scene& recipe = scene.recipe;
  const uint32_t next_index = NextIndex(recipe);
  if (!config.furniture().enabled()) {
    RemoveFurniture(recipe);
    RETURN_IF_ERROR(MakeSolid(scene));
  }
  RETURN_IF_ERROR(AddFloating(config, next_index, scene));
  RETURN_IF_ERROR(Stop(cancel));
  scene.solid.Commit();
  ChooseHouseLighting(config.lighting(), scene);
  RETURN_IF_ERROR(OmitGlassParts(config.assets(), scene));

  const v1::House& house = recipe.place().house();
  const auto part_material = [&](const v1::SceneObject& part, const MaterialSlot& slot,
                                 Palettes& palettes) {
    return HousePartMaterial(house, part, slot, palettes);
  };
  RETURN_IF_ERROR(ChooseMaterials(config.materials(), part_material, scene));
  if (house.ceiling_removed()) {
    RemoveObjects([&](const auto& object) { return GoesWithTheCeiling(house, object); }, recipe);
  }
  if (!StandsInLandscape(config.room(), scene.seed)) return absl::OkStatus();
  RETURN_IF_ERROR(Stop(cancel));
  // Behind whatever floats, so that it has the same indices with and without it.
  return AddLandscape(next_index + kMostFloating, scene);
}

}  // namespace parallax
