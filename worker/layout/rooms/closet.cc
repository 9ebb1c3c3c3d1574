#include "worker/layout/anneal/room_table.h"

namespace parallax {

RoomTable ClosetTable() {
  return {
      .kind = "closet",
      .rows =
          {
              Row("shelf", {"LargeShelf", "CellShelf", "SimpleBookcase", "SingleCabinet"})
                  .Count(2, 4)
                  .BackToWall()
                  .Weight(4),
              Row("chest", {"KitchenCabinet", "SingleCabinet"})
                  .Count(0, 1)
                  .BackToWall()
                  .Below(1.2)
                  .Weight(1.5),
              Row("pallet", {"Pallet"}).Count(0, 1).BackToWall().Weight(0.2),
              Row("mirror", {"Mirror"}).Count(1, 1).OnWall(),
              Row("basket", {"BasketBase"}).Count(1, 2).BackToWall().Or(Stand::kCorner),
          },
      .small =
          {
              {"shelf",
               {"Towel", "Blanket", "Pillow", "BasketBase", "FoodBox", "Jar", "Bottle", "Hardware",
                "Tap", "Lid", "Vase", "BookStack"},
               5,
               12},
              {"chest", {"Towel", "Blanket", "Pillow", "Hardware", "BasketBase"}, 2, 4},
          },
      .wishes = {FloorShare(0.2, 0.6).Weight(4)},
  };
}

}  // namespace parallax
