#include "worker/layout/anneal/room_table.h"

namespace parallax {

RoomTable OfficeTable() {
  return {
      .kind = "office",
      .rows =
          {
              Row("desk", {"SimpleDesk"}).Count(1, 2).BackToWall().OneModel().Weight(6),
              Row("desk chair", {"OfficeChair", "OfficeChair", "Chair"})
                  .Count(1, 2)
                  .InFront("desk", -0.3, 0.05)
                  .FacingIt()
                  .OneModel()
                  .Weight(4),
              Row("monitor", {"Monitor"}).Count(1, 2).OnTop("desk").Weight(2),
              Row("desk lamp", {"DeskLamp"}).Count(0, 2).OnTop("desk"),
              Row("meeting table", {"TableDining"}).Count(0, 1).Free().Weight(2),
              Row("meeting chair", {"Chair", "OfficeChair"})
                  .Count(0, 4)
                  .Around("meeting table", -0.25, 0.08)
                  .OneModel()
                  .Weight(1.5),
              Row("shelf",
                  {"SimpleBookcase", "SimpleBookcase", "LargeShelf", "CellShelf", "SingleCabinet"})
                  .Count(2, 4)
                  .BackToWall()
                  .Weight(3),
              Row("armchair", {"ArmChair", "Sofa"}).Count(0, 1).BackToWall().Or(Stand::kCorner),
              Row("corner shelf", {"TriangleShelf"}).Count(0, 1).SnugCorner(),
              Row("plant", {"LargePlantContainer"})
                  .Count(1, 2)
                  .Corner()
                  .Or(Stand::kBackToWall)
                  .Weight(1.5),
              Row("basket", {"BasketBase"}).Count(0, 1).BackToWall().Or(Stand::kCorner).Weight(0.4),
              Row("rug", {"Rug"}).Count(0, 1).Under("meeting table"),
              Row("art", {"WallArt", "WallArt", "Mirror"}).Count(2, 4).OnWall(),
          },
      .small =
          {
              {"corner shelf",
               {"Vase", "Book", "PlantContainer", "Bowl", "Cup", "Jar", "NatureShelfTrinkets"},
               2,
               6},
              {"desk",
               {"Book", "BookStack", "Cup", "BookColumn", "PlantContainer", "Can", "Bottle"},
               2,
               6},
              {"meeting table", {"Cup", "Book", "Bottle", "PlantContainer", "Vase"}, 1, 4},
              {"armchair", {"Pillow"}, 0, 2, Spread::kSoft},
              {"shelf", {"BookColumn", "BookColumn", "BookStack"}, 3, 8, Spread::kLine},
              {"shelf",
               {"BookStack", "Vase", "Jar", "Bowl", "PlantContainer", "NatureShelfTrinkets",
                "BasketBase", "Cup"},
               2,
               6},
          },
      .wishes =
          {
              EvenlyAround("meeting chair"),
              SpaceAround("meeting table", 0.85, 0.55),
              NearWindow("desk").Weight(0.5),
              NotBeforeWindow("shelf").Weight(0.6),
          },
  };
}

}  // namespace parallax
