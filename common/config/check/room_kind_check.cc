#include "common/config/check/room_kind_check.h"

#include <fmt/core.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "common/base/names.h"
#include "common/config/catalogue_names.h"
#include "common/config/check/field_rules.h"
#include "common/config/config_text.h"

namespace parallax::config_internal {
namespace {

constexpr int kMostRows = 64;

// What a relation needs beside it, and what is allowed there.
struct Relation {
  std::string_view name;
  bool anchor, may_hang, gap, rows, snug;
};
constexpr Relation kRelations[] = {
    {"against_wall", false, false, false, false, false},
    {"in_corner", false, false, false, false, true},
    {"on_floor", false, false, false, true, false},
    {"around", true, false, true, false, false},
    {"in_front_of", true, false, true, false, false},
    {"beside", true, false, true, false, false},
    {"under", true, false, false, false, false},
    {"on_top_of", true, false, false, false, false},
    {"on_wall", false, true, false, false, false},
    {"on_ceiling", false, false, false, false, false},
};

// What a wish needs beside it; nothing else is allowed.
struct WishForm {
  std::string_view name;
  bool group, target, range;
};
constexpr WishForm kWishes[] = {
    {"facing", true, true, false},         {"distance", true, true, true},
    {"away_from", true, true, true},       {"away_from_doors", true, false, true},
    {"in_view", true, true, false},        {"not_before_window", true, false, false},
    {"near_window", true, false, false},   {"same_wall", true, true, false},
    {"sides_free", true, false, false},    {"space_around", true, false, true},
    {"evenly_around", true, false, false}, {"symmetric", true, false, false},
    {"central", true, false, false},       {"apart", true, false, true},
    {"floor_share", false, false, true},
};

template <typename Row>
const Row& Find(const auto& rows, std::string_view name) {
  return *std::find_if(std::begin(rows), std::end(rows),
                       [&](const Row& row) { return row.name == name; });
}

class RoomChecker {
 public:
  RoomChecker(std::string path, Findings& findings) : path_(std::move(path)), findings_(findings) {}

  void Run(const v1::RoomKind& kind) {
    if (!IsName(kind.name())) Tell(Dotted(path_, "name"), WhyNotName(kind.name()));
    if (kind.furniture().empty()) Tell(path_, "no furniture, allowed is one group at least");
    CheckSize(kind.furniture_size(), "furniture");
    CheckSize(kind.things_size(), "things");
    CheckSize(kind.wishes_size(), "wishes");
    for (const v1::RoomFurniture& row : kind.furniture()) all_.push_back(row.group());
    for (int i = 0; i < kind.furniture_size(); ++i) {
      CheckFurniture(kind.furniture(i), At("furniture", i));
      before_.push_back(kind.furniture(i).group());
    }
    for (int i = 0; i < kind.things_size(); ++i) CheckThings(kind.things(i), At("things", i));
    for (int i = 0; i < kind.wishes_size(); ++i) CheckWish(kind.wishes(i), At("wishes", i));
  }

 private:
  std::string At(const char* list, int i) const {
    return Dotted(path_, fmt::format("{}[{}]", list, i));
  }
  void Tell(const std::string& path, std::string what) {
    if (!what.empty()) findings_.push_back({path, std::move(what)});
  }
  // Tells of a part that is needed and absent, or given and without meaning.
  void Need(const std::string& path, const char* part, bool given, bool needed, bool allowed,
            std::string_view beside) {
    if (needed && !given) Tell(path, fmt::format("no {}, which {} needs", part, beside));
    if (given && !needed && !allowed) {
      Tell(Dotted(path, part), fmt::format("given, but {} has none", beside));
    }
  }

  void CheckSize(int size, const char* list) {
    if (size <= kMostRows) return;
    Tell(Dotted(path_, list), fmt::format("a list of {}, allowed are at most {}", size, kMostRows));
  }

  void CheckGroup(const std::string& group, const std::vector<std::string>& known,
                  const std::string& path) {
    Tell(path, WhyNotKnown(group, known, known.empty() ? "none yet" : JoinNames(known)));
  }

  void CheckCount(const v1::CountSpan& count, const std::string& path) {
    if (count.low() <= count.high()) return;
    Tell(path, fmt::format("low {} is above high {}, allowed is the lower one first", count.low(),
                           count.high()));
  }

  void CheckFurniture(const v1::RoomFurniture& row, const std::string& path) {
    if (row.group().empty()) Tell(path, "no group, allowed is a name for it, such as shelf");
    if (std::find(before_.begin(), before_.end(), row.group()) != before_.end()) {
      Tell(Dotted(path, "group"),
           Quoted(row.group()) + " is there already, allowed is another name");
    }
    if (row.classes().empty()) {
      Tell(path, "no classes, allowed are those that `parallax catalogue` lists");
    }
    if (row.has_count()) CheckCount(row.count(), Dotted(path, "count"));
    const std::string stand = row.has_stand() ? row.stand() : "against_wall";
    const Relation& relation = Find<Relation>(kRelations, stand);
    Need(path, "anchor", row.has_anchor(), relation.anchor, relation.may_hang, stand);
    Need(path, "gap_m", row.has_gap_m(), relation.gap, false, stand);
    Need(path, "rows_m", row.has_rows_m(), false, relation.rows, stand);
    Need(path, "snug", row.snug(), false, relation.snug, stand);
    Need(path, "faces_anchor", row.faces_anchor(), false, stand == "in_front_of", stand);
    if (row.has_anchor()) CheckGroup(row.anchor(), before_, Dotted(path, "anchor"));
    if (row.has_looks_at()) CheckGroup(row.looks_at(), all_, Dotted(path, "looks_at"));
  }

  void CheckThings(const v1::RoomThings& row, const std::string& path) {
    CheckGroup(row.bearer(), all_, Dotted(path, "bearer"));
    if (row.classes().empty()) {
      Tell(path, "no classes, allowed are those that `parallax catalogue` lists");
    }
    if (row.has_count()) CheckCount(row.count(), Dotted(path, "count"));
  }

  void CheckWish(const v1::RoomWish& wish, const std::string& path) {
    if (wish.wish().empty()) return Tell(path, "no wish, allowed is one, such as facing");
    const WishForm& form = Find<WishForm>(kWishes, wish.wish());
    Need(path, "group", wish.has_group(), form.group, false, form.name);
    Need(path, "target", wish.has_target(), form.target, false, form.name);
    Need(path, "range", wish.has_range(), form.range, false, form.name);
    if (wish.has_group()) CheckGroup(wish.group(), all_, Dotted(path, "group"));
    if (wish.has_target()) CheckGroup(wish.target(), all_, Dotted(path, "target"));
  }

  const std::string path_;
  Findings& findings_;
  std::vector<std::string> all_, before_;  // Groups of the file, and those of earlier rows.
};

}  // namespace

void CheckRoomKind(const v1::RoomKind& kind, const std::string& path, Findings* findings) {
  RoomChecker(path, *findings).Run(kind);
}

void CheckRoomNames(const v1::RoomConfig& room, const std::string& path, Findings* findings) {
  std::vector<std::string> known = RoomKindNames();
  for (const v1::RoomKind& own : room.own_kinds()) known.push_back(own.name());
  for (int i = 0; i < room.kinds_size(); ++i) {
    std::string why = WhyNotKnown(room.kinds(i), known, JoinNames(known));
    if (!why.empty()) findings->push_back({fmt::format("{}.kinds[{}]", path, i), std::move(why)});
  }
  for (int i = 0; i < room.room_files_size(); ++i) {
    findings->push_back(
        {fmt::format("{}.room_files[{}]", path, i),
         Quoted(room.room_files(i)) + " is a file, allowed here is what it says, as own_kinds"});
  }
}

void CheckOwnKinds(const v1::RoomConfig& room, const std::string& path, Findings* findings) {
  std::vector<std::string> taken = BuiltinNames("rooms/");
  for (int i = 0; i < room.own_kinds_size(); ++i) {
    const v1::RoomKind& kind = room.own_kinds(i);
    const std::string place = fmt::format("{}.own_kinds[{}]", path, i);
    if (std::find(taken.begin(), taken.end(), kind.name()) != taken.end()) {
      findings->push_back({place + ".name", Quoted(kind.name()) +
                                                " is the name of another kind, allowed is one of "
                                                "its own, that of the file or `name`"});
    }
    taken.push_back(kind.name());
    CheckRoomKind(kind, place, findings);
  }
}

}  // namespace parallax::config_internal
