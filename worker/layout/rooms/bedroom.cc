#include "worker/layout/room_table.h"

namespace parallax {

RoomTable BedroomTable() {
  return {
      .kind = "bedroom",
      .rows =
          {
              Row("bed", {"Bed"}).Count(1, 1).BackToWall().Weight(8),
              Row("nightstand", {"SideTable", "SideTable", "SingleCabinet"})
                  .Count(1, 2)
                  .Beside("bed", 0.03, 0.15)
                  .Below(0.8)
                  .OneModel()
                  .Weight(3),
              Row("table lamp", {"DeskLamp"})
                  .Count(1, 2)
                  .OnTop("nightstand")
                  .OneModel()
                  .Weight(1.5),
              Row("wardrobe",
                  {"SingleCabinet", "KitchenCabinet", "LargeShelf", "SimpleBookcase", "CellShelf"})
                  .Count(1, 3)
                  .BackToWall()
                  .Weight(3),
              Row("desk", {"SimpleDesk"}).Count(0, 1).BackToWall().Weight(2),
              Row("desk chair", {"OfficeChair", "Chair"})
                  .Count(0, 1)
                  .InFront("desk", -0.3, 0.05)
                  .FacingIt()
                  .Weight(2),
              Row("armchair", {"ArmChair"}).Count(0, 1).Corner(),
              Row("rug", {"Rug"}).Count(0, 1).Under("bed").Weight(1.5),
              Row("plant", {"LargePlantContainer"}).Count(0, 1).Corner(),
              Row("art over bed", {"WallArt"}).Count(0, 1).OnWall("bed"),
              Row("art", {"WallArt", "Mirror"}).Count(1, 3).OnWall(),
          },
      .small =
          {
              {"nightstand", {"Book", "BookStack", "Cup", "Vase", "PlantContainer"}, 1, 2},
              {"desk", {"Book", "BookStack", "Cup", "BookColumn", "PlantContainer", "Vase"}, 2, 5},
              {"wardrobe", {"BookColumn", "BookStack"}, 2, 5, Spread::kLine},
              {"wardrobe",
               {"Vase", "Jar", "Bowl", "PlantContainer", "NatureShelfTrinkets", "BookStack",
                "Bottle", "Towel"},
               2,
               6},
          },
  };
}

}  // namespace parallax
