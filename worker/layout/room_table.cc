#include "worker/layout/room_table.h"

namespace parallax {

const std::vector<RoomTable>& RoomTables() {
  static const auto* tables = new std::vector<RoomTable>{LivingRoomTable(), DiningRoomTable(),
                                                         BedroomTable(), OfficeTable()};
  return *tables;
}

const RoomTable* FindRoomTable(std::string_view kind) {
  for (const RoomTable& table : RoomTables()) {
    if (table.kind == kind) return &table;
  }
  return nullptr;
}

}  // namespace parallax
