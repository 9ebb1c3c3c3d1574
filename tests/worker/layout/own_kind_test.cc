// A kind of room of the user's own: its file furnishes the room, and the kind that it is like
// builds it.
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "common/config/config.h"
#include "common/config/files/room_files.h"
#include "worker/layout/anneal/room_table.h"
#include "worker/layout/layout.h"

namespace parallax {
namespace {

constexpr char kWorkshop[] =
    "name: workshop\n"
    "like: kitchen\n"
    "furniture:\n"
    "  - {group: bench, classes: [SimpleDesk], count: [2, 3], stand: on_floor, rows_m: 2, weight: "
    "9}\n"
    "  - {group: stool, classes: [BarChair], count: [1, 2], stand: in_front_of, anchor: bench,\n"
    "     gap_m: [-0.2, 0.1], faces_anchor: true}\n"
    "  - {group: shelf, classes: [CellShelf], count: [2, 3], weight: 3}\n"
    "things:\n"
    "  - {bearer: bench, classes: [Can, Jar], count: [2, 6]}\n";

v1::SceneConfig Config(int rooms) {
  v1::SceneConfig config = DefaultSceneConfig();
  v1::RoomConfig& room = *config.mutable_room();
  *room.add_own_kinds() = ParseRoomKind(kWorkshop, "workshop.yaml").value();
  room.clear_kinds();
  room.add_kinds("workshop");
  room.mutable_width_m()->set_constant(6);
  room.mutable_depth_m()->set_constant(5);
  room.mutable_rooms()->set_constant(rooms);
  return config;
}

v1::Layout Solve(const v1::SceneConfig& config, uint64_t seed) {
  const auto solved = SolveLayout(config, SceneSeed{seed}, CancelToken());
  EXPECT_TRUE(solved.ok()) << solved.status();
  const auto* layout = std::get_if<v1::Layout>(&*solved);
  EXPECT_NE(layout, nullptr);
  return layout == nullptr ? v1::Layout() : *layout;
}

TEST(OwnKind, FurnishesItsRoomAndIsBuiltLikeAnother) {
  std::map<std::string, int> seen;
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    const v1::Layout layout = Solve(Config(1), seed);
    const v1::Room& room = layout.place().house().rooms(0);
    EXPECT_EQ(room.own_kind(), "workshop");
    EXPECT_EQ(room.kind(), "kitchen");
    EXPECT_EQ(room.name(), "workshop_0");
    for (const v1::SceneObject& object : layout.objects()) ++seen[object.asset_class()];
  }
  EXPECT_GE(seen["SimpleDesk"], 5);
  EXPECT_GE(seen["CellShelf"], 4);
  EXPECT_GE(seen["BarChair"], 1);
  EXPECT_GE(seen["Can"] + seen["Jar"], 6);
  for (const char* kitchen : {"KitchenSpace", "Oven", "BeverageFridge", "TableDining"}) {
    EXPECT_EQ(seen[kitchen], 0) << kitchen;
  }
}

TEST(OwnKind, IsTheMainRoomOfAHouse) {
  const v1::Layout layout = Solve(Config(3), 2);
  const v1::House& house = layout.place().house();
  ASSERT_EQ(house.rooms_size(), 3);
  EXPECT_EQ(house.rooms(0).own_kind(), "workshop");
  for (int i = 1; i < 3; ++i) {
    EXPECT_EQ(house.rooms(i).own_kind(), "");
    EXPECT_NE(FindRoomTable(house.rooms(i).kind()), nullptr);
  }
}

TEST(OwnKind, BuiltInTablesAreThoseOfTheFiles) {
  const RoomTable& dining = *FindRoomTable("dining_room");
  ASSERT_GE(dining.rows.size(), 2u);
  EXPECT_EQ(dining.rows[1].group, "chair");
  EXPECT_EQ(dining.rows[1].stand, Stand::kAround);
  EXPECT_EQ(dining.rows[1].anchor, "table");
  EXPECT_EQ(dining.rows[1].near_m, -0.25);
  EXPECT_EQ(dining.rows[1].least, 4);
  EXPECT_EQ(dining.rows[1].most, 6);
  EXPECT_TRUE(dining.rows[1].one_model);
  EXPECT_EQ(dining.small[1].spread, Spread::kCentre);
  v1::Room hall;
  hall.set_hall(true);
  hall.set_kind("office");
  EXPECT_EQ(TableOf(hall, v1::RoomConfig()).kind, "office_hall");
  hall.set_kind("kitchen");
  EXPECT_EQ(TableOf(hall, v1::RoomConfig()).kind, "living_room_hall");
}

}  // namespace
}  // namespace parallax
