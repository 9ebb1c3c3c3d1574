#include "worker/scene/types/indoor/room_materials.h"

#include <algorithm>

namespace parallax {
namespace {

// A class or a whole family of the catalogue, and how often it counts.
struct Share {
  const char* name;
  int times;
};

struct Row {
  std::vector<std::string_view> kinds;
  RoomSurface surface;
  std::vector<Share> shares;
};

const std::vector<Row>& Table() {
  static const auto* rows = new std::vector<Row>{
      {{"bathroom"},
       RoomSurface::kFloor,
       {{"CeramicTiles", 3}, {"MosaicTiles", 2}, {"Slate", 1}, {"Marble", 1}, {"Terrazzo", 1}}},
      {{"kitchen"},
       RoomSurface::kFloor,
       {{"CeramicTiles", 4}, {"WoodPlanks", 2}, {"Slate", 1}, {"Terrazzo", 1}, {"Granite", 1}}},
      {{"bedroom", "closet"},
       RoomSurface::kFloor,
       {{"WoodPlanks", 4}, {"WalnutPlanks", 2}, {"ParquetHerringbone", 2}, {"Carpet", 3}}},
      {{"living_room", "dining_room", "office"},
       RoomSurface::kFloor,
       {{"WoodPlanks", 4},
        {"WalnutPlanks", 3},
        {"ParquetHerringbone", 3},
        {"Carpet", 1},
        {"CeramicTiles", 2},
        {"Concrete", 1},
        {"Terrazzo", 1},
        {"Marble", 1}}},
      {{"hallway", "stairs"},
       RoomSurface::kFloor,
       {{"WoodPlanks", 3},
        {"ParquetHerringbone", 2},
        {"CeramicTiles", 3},
        {"Terrazzo", 1},
        {"Slate", 1},
        {"Marble", 1}}},
      {{"bathroom"},
       RoomSurface::kWall,
       {{"CeramicTiles", 3},
        {"SubwayTiles", 3},
        {"MosaicTiles", 1},
        {"WallPaint", 2},
        {"Plaster", 1}}},
      {{"kitchen"},
       RoomSurface::kWall,
       {{"WallPaint", 5},
        {"Plaster", 3},
        {"SubwayTiles", 1},
        {"PaintedBrick", 1},
        {"wallpaper", 1}}},
      {{"living_room", "dining_room", "office", "bedroom", "hallway", "stairs", "closet"},
       RoomSurface::kWall,
       {{"WallPaint", 8},
        {"Plaster", 4},
        {"wallpaper", 2},
        {"Brick", 1},
        {"PaintedBrick", 1},
        {"Concrete", 1}}},
      // White nearly everywhere: a dark one takes the light of the whole room.
      {{"living_room", "dining_room", "office", "bedroom", "hallway", "stairs", "closet", "kitchen",
        "bathroom"},
       RoomSurface::kCeiling,
       {{"CeilingPaint", 8}, {"Plaster", 1}, {"WallPaint", 1}, {"Concrete", 1}}}};
  return *rows;
}

std::vector<const MaterialClass*> Tagged(RoomSurface surface) {
  switch (surface) {
    case RoomSurface::kWall:
      return MaterialsTagged(&MaterialTags::walls);
    case RoomSurface::kFloor:
      return MaterialsTagged(&MaterialTags::floor);
    case RoomSurface::kCeiling:
      return MaterialsTagged(&MaterialTags::ceiling);
  }
  return {};
}

}  // namespace

std::vector<const MaterialClass*> RoomMaterials(std::string_view room_kind, RoomSurface surface) {
  const std::vector<const MaterialClass*> tagged = Tagged(surface);
  std::vector<const MaterialClass*> materials;
  for (const Row& row : Table()) {
    if (row.surface != surface ||
        std::find(row.kinds.begin(), row.kinds.end(), room_kind) == row.kinds.end()) {
      continue;
    }
    for (const Share& share : row.shares) {
      for (const MaterialClass* c : tagged) {
        const bool named = c->name == share.name || c->family == share.name;
        for (int i = 0; named && i < share.times; ++i) materials.push_back(c);
      }
    }
  }
  return materials.empty() ? tagged : materials;
}

}  // namespace parallax
