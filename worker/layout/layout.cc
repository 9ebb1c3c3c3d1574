#include "worker/layout/layout.h"

#include <map>
#include <string>

#include "common/base/rng.h"
#include "common/math/proto.h"
#include "worker/layout/asset_pool.h"
#include "worker/layout/fixtures.h"
#include "worker/layout/furnish.h"
#include "worker/layout/room_plan.h"
#include "worker/layout/room_shell.h"

namespace parallax {
namespace {

// "door_0" is of class "Door".
std::string ClassOfPart(const std::string& part) {
  std::string name = part.substr(0, part.find('_'));
  name[0] = static_cast<char>(name[0] - 'a' + 'A');
  return name;
}

class LayoutWriter {
 public:
  explicit LayoutWriter(v1::Layout& layout) : layout_(layout) {}

  void AddPart(const std::string& part) {
    v1::SceneObject& object = Add(ClassOfPart(part));
    object.set_role(v1::OBJECT_ROLE_ARCHITECTURE);
    object.set_room_part(part);
    *object.mutable_world_from_object() = ToProto(Pose{});
  }

  v1::SceneObject& AddAsset(const PooledAsset& asset, const Vec3d& position, double yaw_rad,
                            v1::ObjectRole role, const std::string& relation) {
    v1::SceneObject& object = Add(asset.class_name);
    object.set_role(role);
    object.set_seed(asset.seed);
    object.set_relation(relation);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(yaw_rad, Vec3d::UnitZ()));
    *object.mutable_world_from_object() = ToProto(Pose{position, turn, 1.0});
    return object;
  }

  // Lights on each emissive slot of the asset; the power is shared among the slots.
  void AddLights(const PooledAsset& asset, const v1::SceneObject& object, const Vec3d& power_w) {
    int emissive = 0;
    for (const MaterialSlot& slot : asset.mesh->slots) emissive += slot.emissive;
    for (const MaterialSlot& slot : asset.mesh->slots) {
      if (!slot.emissive) continue;
      v1::Light& light = *layout_.add_lights();
      light.set_kind(v1::Light::KIND_MESH);
      light.set_name(object.name() + "." + slot.name);
      light.set_object_index(object.index());
      light.set_slot(slot.name);
      *light.mutable_power_w() = ToProto(Vec3d(power_w / emissive));
    }
  }

 private:
  v1::SceneObject& Add(const std::string& asset_class) {
    v1::SceneObject& object = *layout_.add_objects();
    object.set_index(static_cast<uint32_t>(layout_.objects_size()));
    object.set_asset_class(asset_class);
    object.set_name(asset_class + "_" + std::to_string(count_[asset_class]++));
    return object;
  }

  v1::Layout& layout_;
  std::map<std::string, int> count_;
};

absl::Status AddFurniture(const v1::SceneConfig& config, SceneSeed seed, const CancelToken& cancel,
                          const std::vector<Fixture>& fixtures, AssetPool& pool,
                          LayoutWriter& writer, v1::Layout& layout) {
  ASSIGN_OR_RETURN(const Furnishing furnishing,
                   Furnish(layout.room(), config, fixtures, seed, pool, cancel));
  std::vector<uint32_t> index_of;
  for (const FurnishedObject& object : furnishing.objects) {
    v1::SceneObject& entry = writer.AddAsset(*object.asset, object.position, object.yaw_rad,
                                             v1::OBJECT_ROLE_FURNITURE, object.relation);
    if (object.parent >= 0) entry.set_parent_index(index_of[static_cast<size_t>(object.parent)]);
    index_of.push_back(entry.index());
    if (object.lamp_power_w.sum() > 0) writer.AddLights(*object.asset, entry, object.lamp_power_w);
  }
  *layout.mutable_report() = furnishing.report;
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::variant<v1::Layout, Rejected>> SolveLayout(const v1::SceneConfig& config,
                                                               SceneSeed seed,
                                                               const CancelToken& cancel) {
  if (cancel.cancelled()) return absl::CancelledError("layout: cancelled");
  v1::Layout layout;
  ASSIGN_OR_RETURN(*layout.mutable_room(), DrawRoom(config.room(), seed));
  AssetPool pool;
  LayoutWriter writer(layout);
  for (const std::string& part : RoomParts(layout.room())) writer.AddPart(part);
  ASSIGN_OR_RETURN(const std::vector<Fixture> fixtures,
                   PlaceFixtures(layout.room(), config.assets(), seed, pool));
  for (const Fixture& fixture : fixtures) {
    const v1::SceneObject& object =
        writer.AddAsset(*fixture.asset, fixture.position, fixture.yaw_rad,
                        v1::OBJECT_ROLE_LIGHT_FIXTURE, fixture.relation);
    writer.AddLights(*fixture.asset, object, fixture.power_w);
  }
  if (config.furniture().enabled()) {
    RETURN_IF_ERROR(AddFurniture(config, seed, cancel, fixtures, pool, writer, layout));
  }
  return std::variant<v1::Layout, Rejected>(std::move(layout));
}

}  // namespace parallax
