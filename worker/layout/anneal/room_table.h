// The furniture of each kind of room and how it stands: plain tables, one file a kind in
// worker/layout/rooms.
//
// Rows are groups of furniture: their classes, number, and spatial relation. A row names the asset
// classes that can fill it; classes that the catalogue lacks or a config excludes are skipped, and
// a row without any class is left out. Wishes (wish.h) rate the room; HouseholdWishes hold in every
// room.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "parallax/v1/scene.pb.h"
#include "worker/layout/anneal/wish.h"

namespace parallax {

// The spatial relation of an item.
enum class Stand {
  kBackToWall,  // Its back to a wall.
  kCorner,      // In a corner, at an angle.
  kFree,        // Anywhere on the floor, parallel to the walls.
  kAround,      // At the sides of its anchor, facing it: chairs at a table.
  kInFront,     // Before its anchor's front, turned as `faces_anchor` says.
  kBeside,      // Left or right of its anchor, backs in one line.
  kUnder,       // On the floor below its anchor: rugs.
  kOnTop,       // On its anchor's largest support.
  kOnWall,      // Hung on a wall.
  kCeiling,     // Hangs from the ceiling, or floats up to it.
};
// Returns the relation's name in recipes: "against_wall".
std::string_view NameOf(Stand stand);

// One group of furniture. The methods below set the fields, so that tables read like sentences.
struct RoomRow {
  std::string group;
  std::vector<std::string> classes;  // A class named more often comes more often.
  int least = 0, most = 1;           // The number wanted is drawn between the two.
  Stand stand = Stand::kBackToWall;
  std::string anchor;            // Group that it stands by, or hangs above (kOnWall).
  double near_m = 0, far_m = 0;  // Gap to the anchor's edge; negative = pushed in.
  bool faces_anchor = false;  // kInFront: looks at the anchor rather than the way the anchor does.
  std::string looks_at;       // Group that its front should see: proposals aim at it.
  std::vector<Stand> or_stand;             // Relations that the annealing may choose instead.
  double hang_low_m = 0, hang_high_m = 0;  // kOnWall: of its lower edge; 0 = middle at eye level.
  bool snug = false;                       // kCorner: right in the corner, square to it.
  bool one_model = false;                  // All items of the group are the same model.
  double headroom_m = 0;                   // Above it, kept clear of windows and doors.
  double highest_m = 10;                   // Models that are taller are passed over.
  double rows_m = 0;                       // kFree: side by side in rows this far apart; 0: anyhow.
  double weight = 1;                       // Loss for each one that is missing.

  // Setters for the tables.
  RoomRow Count(int low, int high) { return least = low, most = high, *this; }
  RoomRow BackToWall() { return By(Stand::kBackToWall); }
  RoomRow Corner() { return By(Stand::kCorner); }
  RoomRow SnugCorner() { return snug = true, By(Stand::kCorner); }
  RoomRow Free() { return By(Stand::kFree); }
  RoomRow Around(std::string of, double near, double far) {
    return By(Stand::kAround, std::move(of), near, far);
  }
  RoomRow InFront(std::string of, double near, double far) {
    return By(Stand::kInFront, std::move(of), near, far);
  }
  RoomRow Beside(std::string of, double near, double far) {
    return By(Stand::kBeside, std::move(of), near, far);
  }
  RoomRow Under(std::string of) { return By(Stand::kUnder, std::move(of)); }
  RoomRow OnTop(std::string of) { return By(Stand::kOnTop, std::move(of)); }
  RoomRow OnWall(std::string above = "") { return By(Stand::kOnWall, std::move(above)); }
  RoomRow Ceiling() { return By(Stand::kCeiling); }
  // Lets the annealing choose between the relation named first and this one.
  RoomRow Or(Stand other) { return or_stand.push_back(other), *this; }
  RoomRow HungAt(double low, double high) { return hang_low_m = low, hang_high_m = high, *this; }
  RoomRow FacingIt() { return faces_anchor = true, *this; }
  RoomRow LooksAt(std::string target) { return looks_at = std::move(target), *this; }
  RoomRow OneModel() { return one_model = true, *this; }
  RoomRow Headroom(double above_m) { return headroom_m = above_m, *this; }
  RoomRow Below(double height_m) { return highest_m = height_m, *this; }
  RoomRow InRows(double apart_m) { return rows_m = apart_m, *this; }
  RoomRow Weight(double loss) { return weight = loss, *this; }

 private:
  RoomRow By(Stand how, std::string of = "", double near = 0, double far = 0) {
    return stand = how, anchor = std::move(of), near_m = near, far_m = far, *this;
  }
};

// Begins a row: its group and the classes that can fill it.
inline RoomRow Row(std::string group, std::vector<std::string> classes) {
  RoomRow row;
  row.group = std::move(group);
  row.classes = std::move(classes);
  return row;
}

// How small things are distributed on a surface.
enum class Spread {
  kScatter,   // Anywhere on the surface.
  kCentre,    // Near the middle.
  kSettings,  // One before each seat around the bearer, arranged as a table is laid.
  kLine,      // Side by side along the back, as books on a shelf.
  kSoft,      // Dropped on what gives way: pillows on sofas and beds.
};

// Small things on the supports of a group.
struct SmallRow {
  std::string bearer;
  std::vector<std::string> classes;
  int least = 0, most = 3;  // On each bearer in all.
  Spread spread = Spread::kScatter;
};

// The table of one kind of room.
struct RoomTable {
  std::string kind;
  std::vector<RoomRow> rows;  // Anchors before what stands by them.
  std::vector<SmallRow> small;
  std::vector<Wish> wishes;
};

// Returns the wishes of every room: things can be reached and used, walls are not bare, nothing
// stands in heaps.
std::vector<Wish> HouseholdWishes(const RoomTable& table);

// Returns the tables, one a kind of room.
RoomTable LivingRoomTable();
RoomTable DiningRoomTable();
RoomTable BedroomTable();
RoomTable OfficeTable();
RoomTable KitchenTable();
RoomTable BathroomTable();
RoomTable ClosetTable();
RoomTable HallwayTable();
RoomTable StairsTable();

// Returns every table in a fixed order.
const std::vector<RoomTable>& RoomTables();
// Returns the tables of halls, by the kind of room. Other kinds take that of the living room.
const std::vector<RoomTable>& HallTables();
// Returns the table of a kind of room; nullptr for an unknown kind.
const RoomTable* FindRoomTable(std::string_view kind);
// Returns the table of a room of a known kind, hall or not.
const RoomTable& TableOf(const v1::Room& room);

}  // namespace parallax
