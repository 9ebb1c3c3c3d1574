#include "worker/layout/anneal/room_table.h"

namespace parallax {

RoomTable HallwayTable() {
  return {
      .kind = "hallway",
      .rows =
          {
              Row("console", {"SideTable", "TVStand", "SimpleBookcase", "SingleCabinet"})
                  .Count(1, 1)
                  .BackToWall()
                  .Below(1.3)
                  .Weight(3),
              Row("mirror", {"Mirror"}).Count(1, 1).OnWall("console").Weight(1.5),
              Row("bench", {"SimpleDesk", "SideTable"}).Count(0, 1).BackToWall(),
              Row("shelf", {"SimpleBookcase", "CellShelf", "SingleCabinet"})
                  .Count(0, 2)
                  .BackToWall()
                  .Weight(1.5),
              Row("lamp", {"Lamp"}).Count(0, 1).Corner().Weight(0.8),
              Row("plant", {"LargePlantContainer", "LargePlantContainer", "Bush"})
                  .Count(1, 2)
                  .Corner()
                  .Or(Stand::kBackToWall)
                  .Weight(1.2),
              Row("art", {"WallArt"}).Count(2, 5).OnWall(),
          },
      .small =
          {
              {"console", {"Vase", "Bowl", "Book", "PlantContainer", "Hardware"}, 1, 3},
              {"bench", {"Vase", "BookStack", "BasketBase"}, 0, 2},
              {"shelf", {"BookColumn", "BookStack"}, 2, 5, Spread::kLine},
              {"shelf", {"Vase", "Jar", "BasketBase", "NatureShelfTrinkets"}, 2, 5},
          },
      .wishes = {},
  };
}

}  // namespace parallax
