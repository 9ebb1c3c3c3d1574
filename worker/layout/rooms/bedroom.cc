#include "worker/layout/anneal/room_table.h"

namespace parallax {

RoomTable BedroomTable() {
  return {
      .kind = "bedroom",
      .rows =
          {
              Row("bed", {"Bed"}).Count(1, 1).BackToWall().Weight(8),
              Row("nightstand", {"SideTable", "SideTable", "SingleCabinet"})
                  .Count(2, 2)
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
                  .Count(2, 3)
                  .BackToWall()
                  .Weight(3),
              Row("desk", {"SimpleDesk"}).Count(0, 1).BackToWall().Weight(2),
              Row("desk chair", {"OfficeChair", "Chair"})
                  .Count(0, 1)
                  .InFront("desk", -0.3, 0.05)
                  .FacingIt()
                  .Weight(2),
              Row("armchair", {"ArmChair"}).Count(0, 1).Corner(),
              // Bare ones are what guests get.
              Row("guest bed", {"Mattress", "BedFrame"}).Count(0, 1).BackToWall().Weight(0.2),
              Row("rug", {"Rug"}).Count(1, 1).Under("bed").Weight(1.5),
              Row("plant", {"LargePlantContainer"}).Count(0, 1).Corner().Or(Stand::kBackToWall),
              Row("basket", {"BasketBase"}).Count(0, 1).BackToWall().Or(Stand::kCorner).Weight(0.4),
              Row("balloon", {"Balloon"}).Count(0, 1).Ceiling().Weight(0.2),
              Row("art over bed", {"WallArt"}).Count(1, 1).OnWall("bed"),
              Row("art", {"WallArt", "Mirror"}).Count(2, 3).OnWall(),
          },
      .small =
          {
              {"nightstand", {"Book", "BookStack", "Cup", "Vase", "PlantContainer"}, 1, 2},
              {"bed", {"Blanket", "Pillow", "Shirt", "Pants"}, 0, 2, Spread::kSoft},
              {"armchair", {"Pillow", "Blanket"}, 0, 1, Spread::kSoft},
              {"desk", {"Book", "BookStack", "Cup", "BookColumn", "PlantContainer", "Vase"}, 2, 5},
              {"wardrobe", {"BookColumn", "BookStack"}, 2, 5, Spread::kLine},
              {"wardrobe",
               {"Vase", "Jar", "Bowl", "PlantContainer", "NatureShelfTrinkets", "BookStack",
                "Bottle", "Towel", "Blanket", "BasketBase"},
               2,
               6},
          },
      .wishes =
          {
              SidesFree("bed").Weight(1.5),
              Symmetric("nightstand").Weight(2),
              AwayFromDoors("bed", 0.8),
              NotBeforeWindow("wardrobe").Weight(0.6),
              NearWindow("desk").Weight(0.4),
          },
  };
}

}  // namespace parallax
