#include "worker/layout/anneal/room_table.h"

namespace parallax {

std::string_view NameOf(Stand stand) {
  switch (stand) {
    case Stand::kBackToWall:
      return "against_wall";
    case Stand::kCorner:
      return "in_corner";
    case Stand::kFree:
      return "on_floor";
    case Stand::kAround:
      return "around";
    case Stand::kInFront:
      return "in_front_of";
    case Stand::kBeside:
      return "beside";
    case Stand::kUnder:
      return "under";
    case Stand::kOnTop:
      return "on_top_of";
    case Stand::kOnWall:
      return "on_wall";
    case Stand::kCeiling:
      return "on_ceiling";
  }
  return "";
}

std::vector<Wish> HouseholdWishes(const RoomTable& table) {
  std::vector<Wish> wishes = {
      Reachable().Weight(12),
      NoSlits().Weight(1.5),
      BareWalls(2.2).Weight(0.8),
      FloorShare(0.16, 0.5).Weight(8),
  };
  for (const RoomRow& row : table.rows) {
    wishes.push_back(FrontFree(row.group).Weight(2));
    const bool stands = row.stand == Stand::kBackToWall || row.stand == Stand::kCorner;
    if (stands) wishes.push_back(AwayFromDoors(row.group, 0.15).Weight(2));
    if (row.stand == Stand::kOnWall) {
      wishes.push_back(Apart(row.group, 1.1).Weight(0.4));
      wishes.push_back(LevelHeights(row.group).Weight(2));
    }
    // Shelves before windows take the light.
    if (row.stand == Stand::kBackToWall && row.highest_m > 1.2 && row.least >= 2) {
      wishes.push_back(NotBeforeWindow(row.group).Weight(0.5));
    }
  }
  return wishes;
}

const std::vector<RoomTable>& RoomTables() {
  static const auto* tables = new std::vector<RoomTable>{
      LivingRoomTable(), DiningRoomTable(), BedroomTable(), OfficeTable(), KitchenTable(),
      BathroomTable(),   ClosetTable(),     HallwayTable(), StairsTable()};
  return *tables;
}

const RoomTable* FindRoomTable(std::string_view kind) {
  for (const RoomTable& table : RoomTables()) {
    if (table.kind == kind) return &table;
  }
  return nullptr;
}

const RoomTable& TableOf(const v1::Room& room) {
  if (!room.hall()) return *FindRoomTable(room.kind());
  for (const RoomTable& table : HallTables()) {
    if (table.kind == room.kind()) return table;
  }
  return HallTables().front();
}

}  // namespace parallax
