// Halls: what stands in rooms of a hundred square metres. Several groups instead of one, most of
// them free on the floor, in rows where halls have rows.
#include "worker/layout/anneal/room_table.h"

namespace parallax {
namespace {

// Furniture that every hall has along its walls.
void AddWallRows(std::vector<RoomRow>& rows, int shelves) {
  rows.push_back(Row("shelf", {"SimpleBookcase", "SimpleBookcase", "LargeShelf", "LargeShelf",
                               "CellShelf", "SingleCabinet"})
                     .Count(shelves, 2 * shelves)
                     .BackToWall()
                     .Weight(2.5));
  rows.push_back(Row("sideboard", {"SideTable", "TVStand", "KitchenCabinet"})
                     .Count(1, 3)
                     .BackToWall()
                     .Weight(1.5));
  rows.push_back(Row("plant", {"LargePlantContainer"})
                     .Count(4, 9)
                     .Corner()
                     .Or(Stand::kBackToWall)
                     .Or(Stand::kFree)
                     .Weight(2.1));
  rows.push_back(Row("basket", {"BasketBase"}).Count(0, 2).BackToWall().Weight(0.4));
  rows.push_back(
      Row("art", {"WallArt", "WallArt", "WallArt", "Mirror"}).Count(6, 12).OnWall().Weight(1.2));
}

std::vector<SmallRow> ShelvedThings() {
  return {{"sideboard", {"Vase", "Bowl", "PlantContainer", "BookStack", "Bottle", "Jar"}, 2, 5},
          {"shelf", {"BookColumn", "BookColumn", "BookStack"}, 3, 7, Spread::kLine},
          {"shelf",
           {"BookStack", "Vase", "Bowl", "Jar", "Cup", "PlantContainer", "Bottle",
            "NatureShelfTrinkets", "Can", "BasketBase"},
           2,
           6}};
}

// Sofas with low tables before them and armchairs around those.
void AddLoungeRows(std::vector<RoomRow>& rows, int least, int most) {
  rows.push_back(Row("sofa", {"Sofa"}).Count(least, most).Free().Or(Stand::kBackToWall).Weight(10));
  rows.push_back(
      Row("coffee table", {"CoffeeTable"}).Count(least, most).InFront("sofa", 0.3, 0.5).Weight(5));
  rows.push_back(Row("rug", {"Rug"}).Count(least, most).Under("coffee table").Weight(2));
  rows.push_back(Row("armchair", {"ArmChair"})
                     .Count(least, 2 * most)
                     .Around("coffee table", 0.3, 0.6)
                     .OneModel()
                     .Weight(2.5));
  rows.push_back(
      Row("side table", {"SideTable"}).Count(least, most).Beside("sofa", 0.03, 0.12).OneModel());
  rows.push_back(Row("table lamp", {"DeskLamp"}).Count(0, most).OnTop("side table").OneModel());
}

std::vector<SmallRow> LoungeThings() {
  return {{"coffee table",
           {"Book", "BookStack", "Bowl", "FruitContainer", "Cup", "Vase", "PlantContainer"},
           2,
           5},
          {"sofa", {"Pillow", "Pillow", "Blanket"}, 1, 3, Spread::kSoft},
          {"armchair", {"Pillow"}, 0, 1, Spread::kSoft},
          {"side table", {"Book", "Vase", "Cup", "PlantContainer"}, 1, 2}};
}

// Tables with chairs around them.
void AddTableRows(std::vector<RoomRow>& rows, int least, int most) {
  rows.push_back(
      Row("table", {"TableDining"}).Count(least, most).Free().InRows(2.9).OneModel().Weight(8));
  rows.push_back(Row("chair", {"Chair"})
                     .Count(4 * least, 5 * most)
                     .Around("table", -0.25, 0.08)
                     .OneModel()
                     .Weight(2.5));
}

void Append(std::vector<SmallRow>& rows, const std::vector<SmallRow>& more) {
  rows.insert(rows.end(), more.begin(), more.end());
}

RoomTable Lounge() {
  RoomTable table{.kind = "living_room"};
  AddLoungeRows(table.rows, 3, 5);
  AddTableRows(table.rows, 0, 1);
  table.rows.push_back(Row("tv stand", {"TVStand"}).Count(0, 1).BackToWall().Headroom(0.8));
  table.rows.push_back(Row("tv", {"TV"}).Count(0, 1).OnTop("tv stand").Weight(2));
  AddWallRows(table.rows, 4);
  table.small = LoungeThings();
  Append(table.small, ShelvedThings());
  table.wishes = {Apart("sofa", 3.2).Weight(0.8), NotBeforeWindow("shelf").Weight(0.6)};
  return table;
}

RoomTable DiningHall() {
  RoomTable table{.kind = "dining_room"};
  AddTableRows(table.rows, 5, 9);
  AddLoungeRows(table.rows, 0, 1);
  AddWallRows(table.rows, 3);
  table.small = {
      {"table", {"Bowl", "FruitContainer", "PlantContainer", "Vase"}, 1, 1, Spread::kCentre},
      {"table", {"Plate"}, 0, 6, Spread::kSettings},
      {"table", {"Cup", "Bottle", "Bowl", "Jar"}, 1, 3}};
  Append(table.small, ShelvedThings());
  table.wishes = {EvenlyAround("chair").Weight(0.5), NotBeforeWindow("shelf").Weight(0.6)};
  return table;
}

RoomTable OpenOffice() {
  RoomTable table{.kind = "office"};
  table.rows = {
      Row("desk", {"SimpleDesk"}).Count(8, 15).Free().InRows(2.3).OneModel().Weight(6),
      Row("desk chair", {"OfficeChair"})
          .Count(8, 15)
          .InFront("desk", -0.3, 0.05)
          .FacingIt()
          .OneModel()
          .Weight(4),
      Row("monitor", {"Monitor"}).Count(8, 15).OnTop("desk").Weight(2),
      Row("desk lamp", {"DeskLamp"}).Count(0, 6).OnTop("desk").OneModel().Weight(0.5),
  };
  AddTableRows(table.rows, 1, 1);
  AddLoungeRows(table.rows, 0, 1);
  AddWallRows(table.rows, 4);
  table.small = {
      {"desk", {"Book", "BookStack", "Cup", "BookColumn", "PlantContainer", "Can", "Bottle"}, 2, 5},
      {"table", {"Cup", "Book", "Bottle", "PlantContainer", "Vase"}, 1, 4}};
  Append(table.small, ShelvedThings());
  table.wishes = {EvenlyAround("chair").Weight(0.5), NotBeforeWindow("shelf").Weight(0.6)};
  return table;
}

// A dwelling in one room.
RoomTable Loft() {
  RoomTable table{.kind = "bedroom"};
  table.rows = {
      Row("bed", {"Bed"}).Count(1, 2).BackToWall().Weight(10),
      Row("nightstand", {"SideTable"})
          .Count(2, 4)
          .Beside("bed", 0.03, 0.15)
          .Below(0.8)
          .OneModel()
          .Weight(2.5),
      Row("wardrobe", {"SingleCabinet", "LargeShelf", "CellShelf"})
          .Count(2, 4)
          .BackToWall()
          .Weight(3),
      Row("desk", {"SimpleDesk"}).Count(1, 2).BackToWall().Weight(3),
      Row("desk chair", {"OfficeChair", "Chair"})
          .Count(1, 2)
          .InFront("desk", -0.3, 0.05)
          .FacingIt()
          .Weight(2),
      Row("bed rug", {"Rug"}).Count(0, 1).Under("bed"),
  };
  AddLoungeRows(table.rows, 1, 3);
  AddTableRows(table.rows, 1, 2);
  AddWallRows(table.rows, 3);
  table.small = {{"bed", {"Blanket", "Pillow", "Shirt"}, 0, 2, Spread::kSoft},
                 {"nightstand", {"Book", "BookStack", "Cup", "Vase"}, 1, 2},
                 {"desk", {"Book", "BookStack", "Cup", "PlantContainer"}, 2, 5},
                 {"table", {"Bowl", "FruitContainer", "Vase", "Cup"}, 1, 3},
                 {"wardrobe", {"BookColumn", "BookStack"}, 2, 5, Spread::kLine},
                 {"wardrobe", {"Vase", "Jar", "Bowl", "Towel", "BasketBase"}, 2, 5}};
  Append(table.small, LoungeThings());
  Append(table.small, ShelvedThings());
  table.wishes = {SidesFree("bed").Weight(1.5), EvenlyAround("chair").Weight(0.5),
                  NotBeforeWindow("wardrobe").Weight(0.6)};
  return table;
}

}  // namespace

const std::vector<RoomTable>& HallTables() {
  static const auto* tables =
      new std::vector<RoomTable>{Lounge(), DiningHall(), OpenOffice(), Loft()};
  return *tables;
}

}  // namespace parallax
