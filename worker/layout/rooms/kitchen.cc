#include "worker/layout/anneal/room_table.h"

namespace parallax {

RoomTable KitchenTable() {
  return {
      .kind = "kitchen",
      .rows =
          {
              // A run with sink, hood and wall cabinets; what is built in stands beside it.
              Row("counter", {"KitchenSpace"}).Count(1, 1).BackToWall().Weight(8),
              Row("oven", {"Oven"})
                  .Count(1, 1)
                  .Beside("counter", 0.006, 0.012)
                  .Or(Stand::kBackToWall)
                  .Weight(4),
              Row("dishwasher", {"Dishwasher"})
                  .Count(1, 1)
                  .Beside("counter", 0.006, 0.012)
                  .Or(Stand::kBackToWall)
                  .Weight(3),
              Row("cabinet", {"KitchenCabinet"}).Count(1, 2).BackToWall().OneModel().Weight(2.5),
              Row("washing-up", {"Sink"}).Count(0, 1).OnTop("cabinet").Weight(0.5),
              Row("fridge", {"BeverageFridge"}).Count(1, 1).BackToWall().Weight(3),
              Row("island", {"KitchenIsland"}).Count(0, 1).Free().Weight(2),
              Row("table", {"TableDining"}).Count(1, 1).Free().Weight(2),
              Row("chair", {"Chair"}).Count(2, 4).Around("table", -0.25, 0.05).OneModel(),
              Row("standing table", {"TableCocktail"}).Count(0, 1).Free().Weight(0.6),
              Row("bar stool", {"BarChair"})
                  .Count(0, 3)
                  .Around("island", -0.1, 0.1)
                  .OneModel()
                  .Weight(1.2),
              Row("microwave", {"Microwave"}).Count(1, 1).OnTop("counter").Weight(2.5),
              Row("shelf", {"SimpleBookcase", "LargeShelf", "CellShelf"})
                  .Count(0, 2)
                  .BackToWall()
                  .Weight(1.5),
              Row("plant", {"LargePlantContainer"}).Count(0, 1).Corner(),
              Row("art", {"WallArt"}).Count(1, 2).OnWall(),
          },
      .small =
          {
              {"counter",
               {"Pot", "Pan", "Jar", "Bottle", "FoodBox", "FoodBag", "Bowl", "Cup", "Lid", "Can",
                "FruitContainer", "PlantContainer"},
               4,
               9},
              {"cabinet",
               {"Bottle", "Jar", "FruitContainer", "Bowl", "Plate", "Cup", "Wineglass", "FoodBox",
                "Chopsticks", "Knife"},
               2,
               5},
              {"oven", {"Pot", "Pan"}, 1, 2},
              {"island",
               {"FruitContainer", "Bowl", "Vase", "Wineglass", "Bottle", "Cup", "Plate", "Knife",
                "Chopsticks"},
               2,
               6},
              {"table",
               {"Vase", "FruitContainer", "Bowl", "PlantContainer"},
               1,
               1,
               Spread::kCentre},
              {"table", {"Plate"}, 2, 4, Spread::kSettings},
              {"standing table", {"Wineglass", "Bottle", "Cup", "Vase"}, 1, 3},
              {"shelf",
               {"Plate", "Bowl", "Cup", "Wineglass", "Jar", "Bottle", "Pot", "Pan", "Lid", "Can",
                "FoodBag", "FoodBox", "Chopsticks"},
               6,
               12},
          },
      .wishes =
          {
              EvenlyAround("chair"),
              SpaceAround("table", 0.7, 0.6),
              SpaceAround("island", 0.9, 0.85),
              SpaceAround("standing table", 0.4, 0.5),
              EvenlyAround("bar stool"),
              Distance("oven", "counter", 0, 2.4).Weight(1.5),
              Distance("dishwasher", "counter", 0, 2.4).Weight(1.5),
              Distance("fridge", "counter", 0, 3).Weight(0.8),
              SameWall("cabinet", "counter").Weight(0.3),
              NotBeforeWindow("shelf").Weight(0.6),
              NotBeforeWindow("fridge").Weight(0.6),
              NotBeforeWindow("counter").Weight(1.5),
          },
  };
}

}  // namespace parallax
