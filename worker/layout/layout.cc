#include "worker/layout/layout.h"

#include <fmt/core.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/base/rng.h"
#include "common/math/proto.h"
#include "worker/layout/anneal/asset_pool.h"
#include "worker/layout/anneal/fixtures.h"
#include "worker/layout/furnish.h"
#include "worker/layout/plan/house_plan.h"
#include "worker/layout/plan/room_shell.h"

namespace parallax {
namespace {

class LayoutWriter {
 public:
  explicit LayoutWriter(v1::Layout& layout)
      : layout_(layout), house_(*layout.mutable_place()->mutable_house()) {}

  // Sets the room of the house to which the next entries belong.
  void SetRoom(size_t index) { room_ = static_cast<int>(index); }

  void AddPart(const v1::Room& room, const std::string& part) {
    v1::SceneObject& object = Add(ClassOfPart(room, part));
    object.set_role(v1::OBJECT_ROLE_ARCHITECTURE);
    object.set_part(part);
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
    if (room_ > 0) house_.mutable_rooms(room_)->add_object_index(object.index());
    object.set_name(fmt::format("{}_{}", asset_class, count_[asset_class]++));
    return object;
  }

  v1::Layout& layout_;
  v1::House& house_;
  std::map<std::string, int> count_;
  int room_ = 0;
};

// The main room's streams are the scene's own: it does not change with the rest of the house.
SceneSeed SeedOfRoom(SceneSeed seed, size_t room) {
  return room == 0 ? seed : SceneSeed{Rng(seed, "layout/room seed").Child("room", room).Seed()};
}

absl::StatusOr<v1::SolveReport> AddFurniture(const v1::Room& room, const v1::SceneConfig& config,
                                             SceneSeed seed, const CancelToken& cancel,
                                             const std::vector<Fixture>& fixtures, AssetPool& pool,
                                             LayoutWriter& writer) {
  ASSIGN_OR_RETURN(const Furnishing furnishing,
                   Furnish(room, config, fixtures, seed, pool, cancel));
  std::vector<uint32_t> index_of;
  for (const FurnishedObject& object : furnishing.objects) {
    v1::SceneObject& entry = writer.AddAsset(*object.asset, object.position, object.yaw_rad,
                                             v1::OBJECT_ROLE_FURNITURE, object.relation);
    if (object.parent >= 0) entry.set_parent_index(index_of[static_cast<size_t>(object.parent)]);
    index_of.push_back(entry.index());
    if (object.lamp_power_w.sum() > 0) writer.AddLights(*object.asset, entry, object.lamp_power_w);
  }
  return furnishing.report;
}

// The building and its lamps, then the furniture of every room: with furniture off the rest stays
// as it is.
absl::Status FillLayout(const v1::SceneConfig& config, SceneSeed seed, const CancelToken& cancel,
                        const House& house, v1::Layout& layout) {
  AssetPool pool;
  LayoutWriter writer(layout);
  std::vector<std::vector<Fixture>> fixtures;
  for (size_t i = 0; i < house.rooms.size(); ++i) {
    const v1::Room& room = house.rooms[i];
    writer.SetRoom(i);
    for (const std::string& part : RoomParts(room)) writer.AddPart(room, part);
    ASSIGN_OR_RETURN(std::vector<Fixture> lamps,
                     PlaceFixtures(room, config.assets(), SeedOfRoom(seed, i), pool));
    for (const Fixture& fixture : lamps) {
      const v1::SceneObject& object =
          writer.AddAsset(*fixture.asset, fixture.position, fixture.yaw_rad,
                          v1::OBJECT_ROLE_LIGHT_FIXTURE, fixture.relation);
      writer.AddLights(*fixture.asset, object, fixture.power_w);
    }
    fixtures.push_back(std::move(lamps));
  }
  for (size_t i = 0; i < house.rooms.size() && config.furniture().enabled(); ++i) {
    writer.SetRoom(i);
    // The models from which this room chose; other rooms choose from others.
    AssetPool models;
    ASSIGN_OR_RETURN(v1::SolveReport report,
                     AddFurniture(house.rooms[i], config, SeedOfRoom(seed, i), cancel, fixtures[i],
                                  models, writer));
    *(i == 0 ? layout.mutable_report() : layout.add_room_reports()) = std::move(report);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::variant<v1::Layout, Rejected>> SolveLayout(const v1::SceneConfig& config,
                                                               SceneSeed seed,
                                                               const CancelToken& cancel) {
  if (cancel.cancelled()) return Cancelled("layout: cancelled");
  ASSIGN_OR_RETURN(const House house, DrawHouse(config.room(), seed));
  v1::Layout layout;
  for (const v1::Room& room : house.rooms)
    *layout.mutable_place()->mutable_house()->add_rooms() = room;
  if (house.rooms.size() > 1) *layout.add_room_reports() = house.report;
  RETURN_IF_ERROR(FillLayout(config, seed, cancel, house, layout));
  return std::variant<v1::Layout, Rejected>(std::move(layout));
}

}  // namespace parallax
