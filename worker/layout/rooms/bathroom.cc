#include "worker/layout/anneal/room_table.h"

namespace parallax {

RoomTable BathroomTable() {
  return {
      .kind = "bathroom",
      .rows =
          {
              Row("bathtub", {"Bathtub"}).Count(1, 1).BackToWall().Weight(5),
              Row("basin", {"BathroomSink"}).Count(1, 2).BackToWall().OneModel().Weight(6),
              Row("mirror", {"Mirror"}).Count(1, 2).OnWall("basin").Weight(3),
              Row("cabinet", {"SingleCabinet", "SimpleBookcase"})
                  .Count(1, 2)
                  .BackToWall()
                  .Weight(2),
              Row("wash stand", {"SimpleDesk"}).Count(0, 1).BackToWall().Weight(0.4),
              Row("bowl", {"Sink"}).Count(0, 1).OnTop("wash stand"),
              Row("stool", {"SideTable"}).Count(0, 1).BackToWall().Or(Stand::kCorner),
              Row("corner shelf", {"TriangleShelf"}).Count(0, 1).SnugCorner(),
              Row("rug", {"Rug"}).Count(0, 1).Under("bathtub").Weight(0.8),
              Row("basket", {"BasketBase"}).Count(1, 1).BackToWall().Or(Stand::kCorner).Weight(0.8),
              Row("plant", {"LargePlantContainer"}).Count(0, 1).Corner(),
              Row("art", {"WallArt"}).Count(0, 2).OnWall(),
          },
      .small =
          {
              {"corner shelf", {"Towel", "Bottle", "Jar", "Cup", "PlantContainer"}, 3, 6},
              {"cabinet",
               {"Towel", "Towel", "Bottle", "Jar", "Can", "Cup", "PlantContainer", "BasketBase"},
               4,
               9},
              {"wash stand", {"Towel", "Bottle", "Jar", "Cup"}, 1, 3},
              {"stool", {"Towel", "Bottle", "Book"}, 1, 2},
              {"basin", {"Cup", "Bottle", "Jar"}, 0, 2},
          },
      .wishes =
          {
              SameWall("cabinet", "basin").Weight(0.3),
              NotBeforeWindow("basin").Weight(1.5),
              NotBeforeWindow("cabinet").Weight(0.6),
              AwayFromDoors("bathtub", 0.3),
          },
  };
}

}  // namespace parallax
