#include "worker/scene/upgrade.h"

#include <array>
#include <string>
#include <string_view>
#include <utility>

// The one place that reads the fields of earlier releases.
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"

namespace parallax {
namespace {

// Parts had no class of their own once.
std::string ClassOfLegacyPart(const std::string& part) {
  static constexpr std::array<std::pair<std::string_view, const char*>, 6> kClasses = {{
      {"floor", "Floor"},
      {"ceiling", "Ceiling"},
      {"wall", "Wall"},
      {"skirting", "Skirting"},
      {"door", "Door"},
      {"window", "Window"},
  }};
  for (const auto& [prefix, name] : kClasses) {
    if (part.compare(0, prefix.size(), prefix) == 0) return name;
  }
  return part;
}

absl::Status UpgradeObject(int rooms, v1::SceneObject& object, v1::House& house) {
  const uint32_t room = object.legacy_room_index();
  object.clear_legacy_room_index();
  if (!object.part().empty() && object.asset_class().empty()) {
    object.set_asset_class(ClassOfLegacyPart(object.part()));
  }
  if (room == 0) return absl::OkStatus();
  if (room >= static_cast<uint32_t>(rooms)) {
    return InvalidArgument("object {} is in room {} of a house of {} rooms, counted from 0",
                           object.name(), room, rooms);
  }
  house.mutable_rooms(static_cast<int>(room))->add_object_index(object.index());
  return absl::OkStatus();
}

// Makes the place of a recipe or layout from the legacy fields, which are left empty.
template <typename Recipe>
absl::Status UpgradePlace(bool ceiling_removed, Recipe& recipe) {
  if (recipe.has_place()) return absl::OkStatus();
  if (!recipe.has_legacy_room()) {
    recipe.mutable_place()->mutable_open_sky();
    return absl::OkStatus();
  }
  v1::House& house = *recipe.mutable_place()->mutable_house();
  *house.add_rooms() = std::move(*recipe.mutable_legacy_room());
  house.mutable_rooms()->MergeFrom(recipe.legacy_rooms());
  house.set_ceiling_removed(ceiling_removed);
  recipe.clear_legacy_room();
  recipe.clear_legacy_rooms();
  for (v1::SceneObject& object : *recipe.mutable_objects()) {
    RETURN_IF_ERROR(UpgradeObject(house.rooms_size(), object, house));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status UpgradeScene(v1::Scene& scene) {
  const bool ceiling_removed = scene.legacy_ceiling_removed();
  scene.clear_legacy_ceiling_removed();
  return UpgradePlace(ceiling_removed, scene);
}

absl::Status UpgradeLayout(v1::Layout& layout) { return UpgradePlace(false, layout); }

absl::StatusOr<v1::Scene> ParseScene(const std::string& bytes, const std::string& path) {
  v1::Scene scene;
  // Any short file parses as a message with unknown fields; a recipe always says who made it.
  if (!scene.ParseFromString(bytes) || scene.generator_version().empty()) {
    return InvalidArgument("{}: not a scene recipe (they are at <dataset>/<variant>/scenes/*.pb)",
                           path);
  }
  RETURN_IF_ERROR(UpgradeScene(scene));
  return scene;
}

}  // namespace parallax
