#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "common/config/config.h"
#include "worker/layout/furnish.h"
#include "worker/layout/layout.h"
#include "worker/layout/plan/floor_plan.h"
#include "worker/layout/plan/house_plan.h"
#include "worker/layout/plan/room_shell.h"
#include "worker/layout/plan/wall_frame.h"

namespace parallax {
namespace {

v1::RoomConfig HouseConfig(int rooms, double two_storeys_p = 0.4) {
  v1::RoomConfig config = DefaultSceneConfig().room();
  config.mutable_rooms()->set_constant(rooms);
  config.set_two_storeys_p(two_storeys_p);
  return config;
}

Box3f InnerBox(const v1::Room& room) {
  const Vec3d low(room.origin_x_m(), room.origin_y_m(), room.floor_z_m());
  return {low.cast<float>(),
          (low + Vec3d(room.width_m(), room.depth_m(), room.height_m())).cast<float>()};
}

Vec3d PlaceOf(const v1::Room& room, const v1::Opening& o) {
  const WallFrame frame = FrameOfWall(room, o.wall());
  const Vec2d at = frame.At(frame.LocalOf(o.center_m()), -0.5 * o.depth_m());
  return {room.origin_x_m() + at.x(), room.origin_y_m() + at.y(), room.floor_z_m() + o.sill_m()};
}

std::set<size_t> RoomsReached(const House& house) {
  std::set<size_t> reached;
  std::vector<size_t> stack = {0};
  while (!stack.empty()) {
    const size_t r = stack.back();
    stack.pop_back();
    if (!reached.insert(r).second) continue;
    for (const v1::Opening& o : house.rooms[r].openings()) {
      if (o.leads_to() > 0) stack.push_back(o.leads_to() - 1);
    }
  }
  return reached;
}

TEST(House, RoomsOfManyHousesLieApartAndAreAllReached) {
  for (uint64_t seed = 0; seed < 24; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const int wanted = 2 + static_cast<int>(seed % 7);
    const House house = *DrawHouse(HouseConfig(wanted), SceneSeed{seed});
    EXPECT_EQ(static_cast<int>(house.rooms.size()), wanted);
    EXPECT_EQ(RoomsReached(house).size(), house.rooms.size());
    for (size_t i = 0; i < house.rooms.size(); ++i) {
      for (size_t k = 0; k < i; ++k) {
        Box3f a = InnerBox(house.rooms[i]), b = InnerBox(house.rooms[k]);
        EXPECT_TRUE(a.intersection(b).isEmpty() || a.intersection(b).volume() < 1e-6f)
            << house.rooms[i].name() << " and " << house.rooms[k].name();
      }
    }
  }
}

TEST(House, EveryInnerOpeningHasItsMateAtTheSamePlace) {
  for (uint64_t seed = 0; seed < 16; ++seed) {
    const House house = *DrawHouse(HouseConfig(6), SceneSeed{seed});
    for (size_t r = 0; r < house.rooms.size(); ++r) {
      for (const v1::Opening& o : house.rooms[r].openings()) {
        if (o.leads_to() == 0) continue;
        const v1::Room& other = house.rooms[o.leads_to() - 1];
        const bool found = std::any_of(
            other.openings().begin(), other.openings().end(), [&](const v1::Opening& mate) {
              return mate.leads_to() == r + 1 && mate.mated() != o.mated() &&
                     (PlaceOf(other, mate) - PlaceOf(house.rooms[r], o)).norm() < 1e-6;
            });
        EXPECT_TRUE(found) << seed << " " << house.rooms[r].name() << " to " << other.name();
      }
    }
  }
}

bool KeepsItsDoors(const v1::Room& room) {
  return room.kind() == "bathroom" || room.kind() == "closet" || room.kind() == "stairs";
}

// Calls visit(room, opening, room behind) for each opening between rooms, once.
template <typename Visit>
void ForEachDoorway(const House& house, Visit visit) {
  for (const v1::Room& room : house.rooms) {
    for (const v1::Opening& o : room.openings()) {
      if (o.leads_to() > 0 && !o.mated()) visit(room, o, house.rooms[o.leads_to() - 1]);
    }
  }
}

TEST(House, OpenPlansJoinRoomsByWidePassages) {
  double width = 0, closed = 0;
  int passages = 0;
  for (uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    v1::RoomConfig config = HouseConfig(5, 0);
    config.set_open_plan_p(1);
    const House house = *DrawHouse(config, SceneSeed{seed});
    EXPECT_EQ(RoomsReached(house).size(), house.rooms.size());
    ForEachDoorway(house, [&](const v1::Room& a, const v1::Opening& o, const v1::Room& b) {
      if (KeepsItsDoors(a) || KeepsItsDoors(b)) {
        EXPECT_EQ(o.kind(), v1::Opening::KIND_DOOR) << a.name() << " to " << b.name();
        ++closed;
        return;
      }
      EXPECT_EQ(o.kind(), v1::Opening::KIND_PASSAGE) << a.name() << " to " << b.name();
      EXPECT_LT(o.sill_m() + o.height_m(), std::min(a.height_m(), b.height_m()));
      width += o.width_m();
      ++passages;
    });
  }
  ASSERT_GT(passages, 12);
  EXPECT_GT(closed, 0);
  EXPECT_GT(width / passages, 1.7);
}

TEST(House, OpenDoorsStandWideOpenIntoTheOtherRoom) {
  int doors = 0;
  for (uint64_t seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    v1::RoomConfig config = HouseConfig(4, 0);
    ForEachDoorway(
        *DrawHouse(config, SceneSeed{seed}),
        [](const v1::Room&, const v1::Opening& o, const v1::Room&) { EXPECT_EQ(o.open_rad(), 0); });
    config.set_open_door_p(1);
    const House house = *DrawHouse(config, SceneSeed{seed});
    ForEachDoorway(house, [&](const v1::Room& a, const v1::Opening& o, const v1::Room&) {
      if (o.kind() != v1::Opening::KIND_DOOR) return;
      ++doors;
      EXPECT_GE(o.open_rad(), 1.2);
      v1::Room local = a;
      local.clear_openings();
      *local.add_openings() = o;
      const auto leaf = MakeRoomPart(local, "door_0");
      ASSERT_TRUE(leaf.ok()) << leaf.status();
      // It reaches out of its wall nearly as far as it is wide.
      const Vec3f origin = Vec3d(a.origin_x_m(), a.origin_y_m(), a.floor_z_m()).cast<float>();
      const WallFrame wall = FrameOfWall(a, o.wall());
      double out = 0;
      for (const Vec3f& p : leaf->positions) {
        const Vec2d at = (p - origin).head<2>().cast<double>();
        out = std::max(out, -(at - wall.origin).dot(wall.inward));
      }
      EXPECT_GT(out, 0.75 * o.width_m());
    });
  }
  EXPECT_GT(doors, 6);
}

TEST(House, RoomsBesideAHallAreAsHighAsRooms) {
  for (uint64_t seed = 0; seed < 6; ++seed) {
    v1::RoomConfig config = HouseConfig(6, 1.0);
    config.set_hall_p(1);
    const House house = *DrawHouse(config, SceneSeed{seed});
    EXPECT_EQ(RoomsReached(house).size(), house.rooms.size());
    for (size_t i = 1; i < house.rooms.size(); ++i) {
      EXPECT_LT(house.rooms[i].height_m(), 3.1) << house.rooms[i].name();
      EXPECT_FALSE(house.rooms[i].has_stairs());
    }
  }
}

TEST(House, TheMainRoomKeepsItsKindAndSizeWhateverTheHouse) {
  for (uint64_t seed = 0; seed < 8; ++seed) {
    const House alone = *DrawHouse(HouseConfig(1), SceneSeed{seed});
    const House house = *DrawHouse(HouseConfig(7), SceneSeed{seed});
    ASSERT_EQ(alone.rooms.size(), 1u);
    EXPECT_EQ(alone.rooms[0].kind(), house.rooms[0].kind());
    EXPECT_EQ(alone.rooms[0].width_m(), house.rooms[0].width_m());
    EXPECT_EQ(alone.rooms[0].depth_m(), house.rooms[0].depth_m());
    EXPECT_EQ(house.rooms[0].origin_x_m(), 0);
    EXPECT_EQ(house.rooms[0].floor_z_m(), 0);
  }
}

TEST(House, TwoStoreysHaveStairsThatArriveAtTheUpperFloor) {
  int two = 0;
  for (uint64_t seed = 0; seed < 8; ++seed) {
    const House house = *DrawHouse(HouseConfig(7, 1.0), SceneSeed{seed});
    const auto stairs = std::find_if(house.rooms.begin(), house.rooms.end(),
                                     [](const v1::Room& room) { return room.has_stairs(); });
    ASSERT_NE(stairs, house.rooms.end()) << seed;
    for (const v1::Room& room : house.rooms) {
      if (room.floor_z_m() == 0) continue;
      ++two;
      EXPECT_NEAR(room.floor_z_m(), stairs->stairs().rise_m(), 1e-9);
    }
    // A door of the stairs opens onto the landing.
    const bool upper = std::any_of(
        stairs->openings().begin(), stairs->openings().end(), [&](const v1::Opening& o) {
          return o.leads_to() > 0 && std::abs(o.sill_m() - stairs->stairs().rise_m()) < 1e-9;
        });
    EXPECT_TRUE(upper) << seed;
  }
  EXPECT_GT(two, 0);
}

TEST(House, StairsStandInTheirOwnStairwell) {
  for (uint64_t seed = 0; seed < 6; ++seed) {
    const House house = *DrawHouse(HouseConfig(7, 1.0), SceneSeed{seed});
    for (v1::Room room : house.rooms) {
      if (!room.has_stairs()) continue;
      room.clear_origin_x_m();
      room.clear_origin_y_m();
      room.clear_floor_z_m();
      const Box3f box = MakeRoomPart(room, "stairs")->Bounds();
      EXPECT_GT(box.min().x(), -0.01f) << seed;
      EXPECT_GT(box.min().y(), -0.01f) << seed;
      EXPECT_LT(box.max().x(), room.width_m() + 0.01) << seed;
      EXPECT_LT(box.max().y(), room.depth_m() + 0.01) << seed;
      // Two flights reach back to the far wall; a spiral needs less.
      if (ClassOfPart(room, "stairs") == "UShapedStaircase") {
        EXPECT_GT(box.max().y(), room.depth_m() - 0.1) << seed;
      }
    }
  }
}

TEST(House, EveryPartOfEveryRoomIsAValidMesh) {
  for (const uint64_t seed : {1, 2, 3}) {
    const House house = *DrawHouse(HouseConfig(7, 1.0), SceneSeed{seed});
    for (const v1::Room& room : house.rooms) {
      for (const std::string& part : RoomParts(room)) {
        const auto mesh = MakeRoomPart(room, part);
        ASSERT_TRUE(mesh.ok()) << mesh.status();
        EXPECT_TRUE(ValidateMesh(*mesh).ok()) << room.name() << " " << part;
      }
    }
  }
}

TEST(House, FurnishedHouseNamesTheRoomOfEveryObjectAndReportsEachRoom) {
  v1::SceneConfig config = DefaultSceneConfig();
  *config.mutable_room() = HouseConfig(4);
  const auto solved = SolveLayout(config, SceneSeed{5}, CancelToken());
  ASSERT_TRUE(solved.ok()) << solved.status();
  const v1::Layout& layout = std::get<v1::Layout>(*solved);
  const v1::House& house = layout.place().house();
  ASSERT_EQ(house.rooms_size(), 4);
  EXPECT_EQ(layout.room_reports_size(), 4);  // The floor plan and the three others.
  std::map<int, int> furniture;
  for (const v1::SceneObject& object : layout.objects()) {
    const int index = RoomIndexOf(house, object.index());
    ASSERT_LE(index, 3);
    furniture[index] += object.role() == v1::OBJECT_ROLE_FURNITURE;
    const v1::Room& room = house.rooms(index);
    if (!object.part().empty()) continue;
    const Box3f box = InnerBox(room);
    const v1::Transform& at = object.world_from_object();
    EXPECT_TRUE(box.contains(Vec3d(at.tx(), at.ty(), at.tz() + 0.01).cast<float>()) ||
                object.relation() == "on_ceiling")
        << object.name();
  }
  for (int r = 0; r < 4; ++r) EXPECT_GT(furniture[r], 0) << r;
}

TEST(FloorPlan, AnnealingLowersTheLoss) {
  double initial = 0, final = 0;
  for (uint64_t seed = 0; seed < 6; ++seed) {
    const House house = *DrawHouse(HouseConfig(8), SceneSeed{seed});
    initial += house.report.initial_loss();
    final += house.report.final_loss();
    EXPECT_LT(house.report.final_loss(), house.report.initial_loss());
  }
  EXPECT_LT(final, 0.7 * initial);
}

TEST(FloorPlan, BathroomsAreNotOffKitchensWhereAHallwayIsToBeHad) {
  EXPECT_GT(LinkCost("bathroom", "kitchen"), LinkCost("bathroom", "hallway"));
  EXPECT_LT(LinkCost("living_room", "dining_room"), LinkCost("bedroom", "kitchen"));
}

TEST(RoomTables, EveryClassOfTheCatalogueHasSomewhereToBe) {
  const std::vector<std::string> placed = PlacedClasses();
  // Flights that climb straight or in a bend need a hall longer than the house's stairwell.
  const std::set<std::string> elsewhere = {"StraightStaircase", "CurvedStaircase"};
  for (const AssetClass& c : AssetCatalogue()) {
    if (!c.on_by_default || elsewhere.count(c.name) > 0) continue;
    EXPECT_TRUE(std::binary_search(placed.begin(), placed.end(), c.name)) << c.name;
  }
  for (const std::string& name : placed) EXPECT_NE(FindAssetClass(name), nullptr) << name;
}

}  // namespace
}  // namespace parallax
