#include "worker/scene/types/indoor/house_materials.h"

#include <fmt/core.h>

#include "worker/layout/plan/room_shell.h"
#include "worker/scene/types/indoor/room_materials.h"

namespace parallax {

uint32_t HousePartMaterial(const v1::House& house, const v1::SceneObject& object,
                           const MaterialSlot& slot, Palettes& palettes) {
  const int index = RoomIndexOf(house, object.index());
  const std::string& kind = house.rooms(index).kind();
  const std::string room = index == 0 ? "room/" : fmt::format("room_{}/", index);
  const Rng& root = palettes.root();
  const Rng where = root.Child(room + slot.name);
  const auto of_room = [&](RoomSurface surface, const std::string& palette) {
    return palettes.FromPalette(RoomMaterials(kind, surface), index == 0 ? palette : room + palette,
                                1, where);
  };
  if (slot.name == "wall") return of_room(RoomSurface::kWall, "wall");
  if (slot.name == "floor") return of_room(RoomSurface::kFloor, "floor");
  if (slot.name == "ceiling") return of_room(RoomSurface::kCeiling, "ceiling");
  if (slot.name == "cornice") {
    return palettes.FromPalette(MaterialsTagged(&MaterialTags::ceiling), "ceiling", 1, where);
  }
  // All joinery is painted alike; doors now and then are bare wood.
  if (slot.name == "skirting" || slot.name == "frame" || slot.name == "leaf") {
    const bool wood =
        root.Child(slot.name == "leaf" ? "wooden leaf" : "wooden trim").Bernoulli(0.3);
    return palettes.FromPalette(MaterialsOfFamily(wood ? "wood" : "LacquerPaint"),
                                wood ? "wood" : "trim", 1, where);
  }
  return palettes.FromFamilies(slot, root.Child("room/" + slot.name), "room/" + slot.name, 1);
}

}  // namespace parallax
