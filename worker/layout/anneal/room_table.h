// The furniture of each kind of room and how it stands, made of the files of common/config
// (room_files.h).
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

#include "parallax/v1/config.pb.h"
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

// One group of furniture (v1::RoomFurniture).
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
};

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

// Returns the table of a kind; without wishes that the file does not have.
RoomTable TableOf(const v1::RoomKind& kind);
// Returns every built-in table, in order of name; those of halls are called "..._hall".
const std::vector<RoomTable>& RoomTables();
// Returns the table of a built-in kind of room; nullptr for an unknown kind.
const RoomTable* FindRoomTable(std::string_view kind);
// Returns the table of a room: one of the config's own, or a built-in one, of a hall where it is
// one. Kinds without a hall take that of the living room.
RoomTable TableOf(const v1::Room& room, const v1::RoomConfig& config);

}  // namespace parallax
