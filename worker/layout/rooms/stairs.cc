#include "worker/layout/anneal/room_table.h"

namespace parallax {

RoomTable StairsTable() {
  return {
      .kind = "stairs",
      .rows =
          {
              Row("plant", {"LargePlantContainer"}).Count(0, 1).Corner().Below(1.6),
              Row("art", {"WallArt"}).Count(2, 4).OnWall(),
          },
      .small = {},
      .wishes = {},
  };
}

}  // namespace parallax
