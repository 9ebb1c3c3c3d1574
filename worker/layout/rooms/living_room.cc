#include "worker/layout/room_table.h"

namespace parallax {

RoomTable LivingRoomTable() {
  return {
      .kind = "living_room",
      .rows =
          {
              Row("sofa", {"Sofa"}).Count(1, 1).BackToWall().LooksAt("tv stand").Weight(6),
              Row("tv stand", {"TVStand"}).Count(1, 1).BackToWall().LooksAt("sofa").Weight(4),
              Row("tv", {"TV"}).Count(1, 1).OnTop("tv stand").Weight(3),
              Row("coffee table", {"CoffeeTable"})
                  .Count(1, 1)
                  .InFront("sofa", 0.3, 0.5)
                  .Weight(4),
              Row("rug", {"Rug"}).Count(0, 1).Under("coffee table").Weight(2),
              Row("armchair", {"ArmChair"})
                  .Count(0, 2)
                  .Free()
                  .LooksAt("coffee table")
                  .OneModel()
                  .Weight(2),
              Row("side table", {"SideTable"})
                  .Count(0, 2)
                  .Beside("sofa", 0.03, 0.12)
                  .OneModel()
                  .Weight(1.5),
              Row("table lamp", {"DeskLamp"}).Count(0, 1).OnTop("side table"),
              Row("shelf", {"SimpleBookcase", "SimpleBookcase", "LargeShelf", "CellShelf",
                            "SingleCabinet", "KitchenCabinet"})
                  .Count(1, 3)
                  .BackToWall()
                  .Weight(2.5),
              Row("corner shelf", {"TriangleShelf"}).Count(0, 1).SnugCorner(),
              Row("plant", {"LargePlantContainer"}).Count(1, 2).Corner().Weight(1.5),
              Row("art over sofa", {"WallArt", "Mirror"}).Count(0, 1).OnWall("sofa"),
              Row("art", {"WallArt", "WallArt", "Mirror"}).Count(1, 3).OnWall(),
          },
      .small =
          {
              {"corner shelf",
               {"Vase", "Book", "PlantContainer", "Bowl", "Cup", "Jar", "NatureShelfTrinkets"},
               2,
               6},
              {"coffee table",
               {"Book", "BookStack", "Bowl", "FruitContainer", "Cup", "Vase", "PlantContainer",
                "Wineglass", "NatureShelfTrinkets"},
               2,
               5},
              {"side table", {"Book", "BookStack", "Vase", "Cup", "PlantContainer", "Jar"}, 1, 2},
              {"tv stand", {"BookColumn", "BookStack", "Vase", "Jar", "NatureShelfTrinkets"}, 1, 4},
              {"shelf", {"BookColumn", "BookColumn", "BookStack"}, 3, 7, Spread::kLine},
              {"shelf",
               {"BookStack", "Vase", "Bowl", "Jar", "Cup", "PlantContainer", "Bottle",
                "NatureShelfTrinkets", "Can"},
               3,
               8},
          },
  };
}

}  // namespace parallax
