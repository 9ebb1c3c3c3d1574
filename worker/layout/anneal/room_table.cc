#include "worker/layout/anneal/room_table.h"

#include <algorithm>
#include <iterator>

#include "common/config/files/room_files.h"

namespace parallax {
namespace {

constexpr std::string_view kStands[] = {"against_wall", "in_corner", "on_floor", "around",
                                        "in_front_of",  "beside",    "under",    "on_top_of",
                                        "on_wall",      "on_ceiling"};
constexpr std::string_view kSpreads[] = {"scatter", "centre", "settings", "line", "soft"};

// Returns the value of the enum whose values have these names, in order.
template <typename Enum>
Enum ValueOf(const auto& names, std::string_view name) {
  return static_cast<Enum>(std::find(std::begin(names), std::end(names), name) - std::begin(names));
}

std::vector<std::string> Texts(const google::protobuf::RepeatedPtrField<std::string>& texts) {
  return {texts.begin(), texts.end()};
}

RoomRow RowOf(const v1::RoomFurniture& row) {
  RoomRow made;
  made.group = row.group();
  made.classes = Texts(row.classes());
  if (row.has_count()) made.least = row.count().low(), made.most = row.count().high();
  if (row.has_stand()) made.stand = ValueOf<Stand>(kStands, row.stand());
  made.anchor = row.anchor();
  made.near_m = row.gap_m().near();
  made.far_m = row.gap_m().far();
  made.faces_anchor = row.faces_anchor();
  made.looks_at = row.looks_at();
  for (const std::string& stand : row.or_stand()) {
    made.or_stand.push_back(ValueOf<Stand>(kStands, stand));
  }
  made.snug = row.snug();
  made.one_model = row.one_model();
  made.headroom_m = row.headroom_m();
  if (row.has_highest_m()) made.highest_m = row.highest_m();
  made.rows_m = row.rows_m();
  if (row.has_weight()) made.weight = row.weight();
  return made;
}

SmallRow RowOf(const v1::RoomThings& row) {
  SmallRow made{.bearer = row.bearer(), .classes = Texts(row.classes())};
  if (row.has_count()) made.least = row.count().low(), made.most = row.count().high();
  if (row.has_spread()) made.spread = ValueOf<Spread>(kSpreads, row.spread());
  return made;
}

using MakeWish = Wish (*)(const v1::RoomWish& wish);
constexpr std::pair<std::string_view, MakeWish> kWishes[] = {
    {"facing", [](const v1::RoomWish& w) { return Facing(w.group(), w.target()); }},
    {"distance",
     [](const v1::RoomWish& w) {
       return Distance(w.group(), w.target(), w.range().near(), w.range().far());
     }},
    {"away_from",
     [](const v1::RoomWish& w) { return AwayFrom(w.group(), w.target(), w.range().near()); }},
    {"away_from_doors",
     [](const v1::RoomWish& w) { return AwayFromDoors(w.group(), w.range().near()); }},
    {"in_view", [](const v1::RoomWish& w) { return InView(w.group(), w.target()); }},
    {"not_before_window", [](const v1::RoomWish& w) { return NotBeforeWindow(w.group()); }},
    {"near_window", [](const v1::RoomWish& w) { return NearWindow(w.group()); }},
    {"same_wall", [](const v1::RoomWish& w) { return SameWall(w.group(), w.target()); }},
    {"sides_free", [](const v1::RoomWish& w) { return SidesFree(w.group()); }},
    {"space_around",
     [](const v1::RoomWish& w) {
       return SpaceAround(w.group(), w.range().near(), w.range().far());
     }},
    {"evenly_around", [](const v1::RoomWish& w) { return EvenlyAround(w.group()); }},
    {"symmetric", [](const v1::RoomWish& w) { return Symmetric(w.group()); }},
    {"central", [](const v1::RoomWish& w) { return Central(w.group()); }},
    {"apart", [](const v1::RoomWish& w) { return Apart(w.group(), w.range().near()); }},
    {"floor_share",
     [](const v1::RoomWish& w) { return FloorShare(w.range().near(), w.range().far()); }},
};

Wish WishOf(const v1::RoomWish& wish) {
  const auto* made = std::find_if(std::begin(kWishes), std::end(kWishes),
                                  [&](const auto& row) { return row.first == wish.wish(); });
  return made->second(wish).Weight(wish.has_weight() ? wish.weight() : 1);
}

}  // namespace

std::string_view NameOf(Stand stand) { return kStands[static_cast<size_t>(stand)]; }

std::vector<Wish> HouseholdWishes(const RoomTable& table) {
  std::vector<Wish> wishes = {
      Reachable().Weight(12),
      NoSlits().Weight(1.5),
      BareWalls(2.2).Weight(0.8),
      FloorShare(0.16, 0.5).Weight(8),
  };
  for (const RoomRow& row : table.rows) {
    wishes.push_back(FrontFree(row.group).Weight(2));
    const bool stands = row.stand == Stand::kBackToWall || row.stand == Stand::kCorner;
    if (stands) wishes.push_back(AwayFromDoors(row.group, 0.15).Weight(2));
    if (row.stand == Stand::kOnWall) {
      wishes.push_back(Apart(row.group, 1.1).Weight(0.4));
      wishes.push_back(LevelHeights(row.group).Weight(2));
    }
    // Shelves before windows take the light.
    if (row.stand == Stand::kBackToWall && row.highest_m > 1.2 && row.least >= 2) {
      wishes.push_back(NotBeforeWindow(row.group).Weight(0.5));
    }
  }
  return wishes;
}

RoomTable TableOf(const v1::RoomKind& kind) {
  RoomTable table{.kind = kind.name()};
  for (const v1::RoomFurniture& row : kind.furniture()) table.rows.push_back(RowOf(row));
  for (const v1::RoomThings& row : kind.things()) table.small.push_back(RowOf(row));
  for (const v1::RoomWish& wish : kind.wishes()) table.wishes.push_back(WishOf(wish));
  return table;
}

const std::vector<RoomTable>& RoomTables() {
  static const auto& tables = *[] {
    auto* made = new std::vector<RoomTable>();
    for (const v1::RoomKind& kind : BuiltinRoomKinds()) made->push_back(TableOf(kind));
    return made;
  }();
  return tables;
}

const RoomTable* FindRoomTable(std::string_view kind) {
  for (const RoomTable& table : RoomTables()) {
    if (table.kind == kind) return &table;
  }
  return nullptr;
}

RoomTable TableOf(const v1::Room& room, const v1::RoomConfig& config) {
  for (const v1::RoomKind& own : config.own_kinds()) {
    if (own.name() == room.own_kind()) return TableOf(own);
  }
  if (!room.hall()) return *FindRoomTable(room.kind());
  const RoomTable* const hall = FindRoomTable(room.kind() + "_hall");
  return hall != nullptr ? *hall : *FindRoomTable("living_room_hall");
}

}  // namespace parallax
