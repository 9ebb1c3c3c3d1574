#include "worker/layout/anneal/room_table.h"

namespace parallax {

RoomTable DiningRoomTable() {
  return {
      .kind = "dining_room",
      .rows =
          {
              Row("table", {"TableDining"}).Count(1, 1).Free().Weight(8),
              Row("chair", {"Chair"})
                  .Count(4, 6)
                  .Around("table", -0.25, 0.08)
                  .OneModel()
                  .Weight(2.5),
              Row("rug", {"Rug"}).Count(0, 1).Under("table").Weight(2),
              Row("shelf",
                  {"SimpleBookcase", "LargeShelf", "CellShelf", "SingleCabinet", "KitchenCabinet"})
                  .Count(2, 4)
                  .BackToWall()
                  .Weight(3),
              Row("sideboard", {"SideTable", "TVStand", "KitchenCabinet", "KitchenCabinet"})
                  .Count(1, 1)
                  .BackToWall()
                  .Weight(1.5),
              Row("fridge", {"BeverageFridge"}).Count(0, 1).BackToWall().Weight(0.5),
              Row("microwave", {"Microwave"}).Count(0, 1).OnTop("sideboard").Weight(0.5),
              Row("stool", {"BarChair"}).Count(0, 1).BackToWall().OneModel().Weight(0.5),
              Row("corner shelf", {"TriangleShelf"}).Count(0, 1).SnugCorner(),
              Row("plant", {"LargePlantContainer"})
                  .Count(1, 2)
                  .Corner()
                  .Or(Stand::kBackToWall)
                  .Weight(1.5),
              Row("art over sideboard", {"WallArt", "Mirror"}).Count(0, 1).OnWall("sideboard"),
              Row("art", {"WallArt", "WallArt", "Mirror"}).Count(2, 4).OnWall(),
          },
      .small =
          {
              {"corner shelf",
               {"Vase", "Book", "PlantContainer", "Bowl", "Cup", "Jar", "NatureShelfTrinkets"},
               2,
               6},
              {"table",
               {"Vase", "FruitContainer", "Bowl", "PlantContainer"},
               1,
               1,
               Spread::kCentre},
              {"table", {"Plate"}, 2, 6, Spread::kSettings},
              {"table", {"Cup", "Bottle", "Bowl", "Jar", "Pot"}, 0, 2},
              {"sideboard", {"Vase", "Bowl", "PlantContainer", "BookStack", "Bottle"}, 1, 3},
              {"shelf", {"BookColumn", "BookStack"}, 1, 4, Spread::kLine},
              {"shelf",
               {"Plate", "Bowl", "Cup", "Wineglass", "Jar", "Bottle", "Pot", "Pan", "Vase", "Can",
                "NatureShelfTrinkets", "FoodBag", "FoodBox"},
               4,
               10},
          },
      .wishes =
          {
              EvenlyAround("chair"),
              SpaceAround("table", 0.85, 0.6),
              Central("table").Weight(1.5),
              NotBeforeWindow("shelf").Weight(0.6),
          },
  };
}

}  // namespace parallax
