#include "worker/layout/anneal/room_table.h"

namespace parallax {

RoomTable LivingRoomTable() {
  return {
      .kind = "living_room",
      .rows =
          {
              Row("sofa", {"Sofa"}).Count(1, 1).BackToWall().LooksAt("tv stand").Weight(12),
              Row("tv stand", {"TVStand"})
                  .Count(1, 1)
                  .BackToWall()
                  .LooksAt("sofa")
                  .Headroom(0.8)
                  .Weight(5),
              Row("tv", {"TV"}).Count(1, 1).OnTop("tv stand").Weight(5),
              Row("coffee table", {"CoffeeTable"}).Count(1, 1).InFront("sofa", 0.3, 0.5).Weight(4),
              Row("rug", {"Rug"}).Count(1, 1).Under("coffee table").Weight(2),
              Row("armchair", {"ArmChair"})
                  .Count(0, 2)
                  .Free()
                  .Or(Stand::kCorner)
                  .LooksAt("coffee table")
                  .OneModel()
                  .Weight(2),
              Row("side table", {"SideTable"})
                  .Count(1, 2)
                  .Beside("sofa", 0.03, 0.12)
                  .OneModel()
                  .Weight(1.5),
              Row("table lamp", {"DeskLamp"}).Count(0, 2).OnTop("side table").OneModel(),
              Row("shelf", {"SimpleBookcase", "SimpleBookcase", "LargeShelf", "CellShelf",
                            "SingleCabinet", "KitchenCabinet"})
                  .Count(2, 4)
                  .BackToWall()
                  .Weight(2.5),
              Row("corner shelf", {"TriangleShelf"}).Count(0, 1).SnugCorner(),
              Row("plant", {"LargePlantContainer"})
                  .Count(1, 2)
                  .Corner()
                  .Or(Stand::kBackToWall)
                  .Weight(1.5),
              Row("basket", {"BasketBase"}).Count(0, 1).BackToWall().Or(Stand::kCorner).Weight(0.4),
              Row("balloon", {"Balloon"}).Count(0, 1).Ceiling().Weight(0.2),
              Row("art over sofa", {"WallArt", "Mirror"}).Count(1, 1).OnWall("sofa"),
              Row("art", {"WallArt", "WallArt", "Mirror"}).Count(2, 4).OnWall(),
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
              {"sofa", {"Pillow", "Pillow", "Pillow", "Blanket"}, 1, 3, Spread::kSoft},
              {"armchair", {"Pillow"}, 0, 1, Spread::kSoft},
              {"side table", {"Book", "BookStack", "Vase", "Cup", "PlantContainer", "Jar"}, 1, 2},
              {"tv stand", {"BookColumn", "BookStack", "Vase", "Jar", "NatureShelfTrinkets"}, 1, 4},
              {"shelf", {"BookColumn", "BookColumn", "BookStack"}, 3, 7, Spread::kLine},
              {"shelf",
               {"BookStack", "Vase", "Bowl", "Jar", "Cup", "PlantContainer", "Bottle",
                "NatureShelfTrinkets", "Can"},
               3,
               8},
          },
      .wishes =
          {
              Facing("sofa", "tv stand").Weight(4),
              Facing("tv stand", "sofa").Weight(4),
              Distance("sofa", "tv stand", 1.8, 4.2).Weight(1.5),
              InView("sofa", "tv stand").Weight(1.5),
              NotBeforeWindow("tv stand").Weight(2.5),
              NotBeforeWindow("shelf").Weight(0.6),
              Facing("armchair", "coffee table").Weight(4),
              Distance("armchair", "coffee table", 0.9, 1.6).Weight(1.5),
              SpaceAround("armchair", 0.25, 0.15),
              Symmetric("side table").Weight(0.8),
              AwayFrom("shelf", "sofa", 0.3).Weight(0.8),
          },
  };
}

}  // namespace parallax
