#include "worker/layout/plan/house_plan.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "common/base/rng.h"
#include "common/config/config.h"
#include "worker/layout/plan/floor_plan.h"
#include "worker/layout/plan/open_plan.h"
#include "worker/layout/plan/room_plan.h"

namespace parallax {
namespace {

constexpr int kPlanSteps = 3000;
constexpr int kPlans = 4;                // Tries until every room can be reached.
constexpr double kCeilingSlab_m = 0.45;  // Between two storeys.
constexpr double kLanding_m = 1.25;
constexpr double kBesideHall_m = 2.8;  // Height of rooms.
constexpr int kHallWindows = 3;        // For each window of a room.
constexpr double kRise_m = 0.178, kRun_m = 0.25, kFlight_m = 0.86;

struct KindGoal {
  const char* kind;
  double low_m2, high_m2, least_m;
};
constexpr KindGoal kGoals[] = {{"living_room", 17, 27, 3.4}, {"dining_room", 12, 19, 3.0},
                               {"kitchen", 9, 15, 2.6},      {"bedroom", 11, 17, 2.9},
                               {"bathroom", 5, 8.5, 2.0},    {"closet", 2.8, 5, 1.5},
                               {"hallway", 5, 10, 1.4},      {"office", 8, 13, 2.6}};

Cell MakeCell(const std::string& kind, double wall_m, Rng rng) {
  Cell cell;
  cell.kind = kind;
  for (const KindGoal& goal : kGoals) {
    if (kind != goal.kind) continue;
    const double side = std::sqrt(rng.Uniform(goal.low_m2, goal.high_m2)) + wall_m;
    cell.goal_m2 = side * side;
    cell.least_m = goal.least_m + wall_m;
  }
  return cell;
}

// Draws the kinds of a house's other rooms; rooms that every house needs come first.
std::vector<std::string> DrawKinds(const std::string& main, int count, Rng rng) {
  struct Wish {
    std::string kind;
    double rank;
  };
  std::vector<Wish> wishes;
  const char* order[] = {"hallway",     "kitchen", "living_room", "bathroom", "bedroom",
                         "dining_room", "office",  "closet",      "bedroom"};
  bool main_taken = false;
  for (const char* kind : order) {
    const double rank = static_cast<double>(wishes.size()) + rng.Uniform(0, 2.5);
    if (!main_taken && kind == main) {
      main_taken = true;
      continue;
    }
    wishes.push_back({kind, rank});
  }
  std::stable_sort(wishes.begin(), wishes.end(),
                   [](const Wish& a, const Wish& b) { return a.rank < b.rank; });
  std::vector<std::string> kinds;
  for (int i = 0; i < count && i < static_cast<int>(wishes.size()); ++i) {
    kinds.push_back(wishes[static_cast<size_t>(i)].kind);
  }
  return kinds;
}

// Puts most bedrooms, bathrooms, closets and offices upstairs; at least one room goes there.
void ChooseStoreys(std::vector<Cell>& cells, Rng rng) {
  bool any = false;
  for (size_t i = 2; i < cells.size(); ++i) {
    const std::string& kind = cells[i].kind;
    const bool private_room =
        kind == "bedroom" || kind == "bathroom" || kind == "closet" || kind == "office";
    cells[i].storey = private_room && rng.Bernoulli(0.8);
    any |= cells[i].storey == 1;
  }
  if (!any) cells.back().storey = 1;
}

v1::Stairs DrawStairs(double rise_m, Rng rng) {
  v1::Stairs stairs;
  stairs.set_rise_m(rise_m);
  stairs.set_width_m(2 * kFlight_m + 0.12);
  const int flight = static_cast<int>(std::lround((rise_m / kRise_m - 1) / 2));
  stairs.set_length_m(flight * kRun_m + kFlight_m);
  stairs.set_landing_m(kLanding_m);
  stairs.set_seed(rng.Seed());
  return stairs;
}

class HouseBuilder {
 public:
  HouseBuilder(const v1::RoomConfig& config, SceneSeed seed, v1::Room main)
      : config_(config), root_(seed, "layout/house"), rooms_({std::move(main)}) {}

  House Build(int count) {
    // Two rooms share each inner wall, and each owns half of it.
    wall_m_ = std::clamp(rooms_[0].wall_thickness_m(), 0.2, 0.28);
    DrawHeights();
    FloorPlan plan = Place(DrawCells(count));
    MakeRooms(plan);
    for (const auto& [a, b] : plan.links.pairs) Join(plan, a, b);
    JoinTheRest(plan);
    ExtraPassages(plan);
    for (size_t i = 0; i < rooms_.size(); ++i) AddOutsideOpenings(plan, i);
    House house;
    FillReport(plan, house.report);
    house.rooms = std::move(rooms_);
    return house;
  }

 private:
  void DrawHeights() {
    // Rooms beside a hall are as high as rooms are.
    height_m_ = rooms_[0].hall() ? kBesideHall_m : rooms_[0].height_m();
    double highest = height_m_;
    Rng rng = root_.Child("heights");
    for (double& offset : height_offsets_) {
      offset = 0.1 * rng.UniformInt(-3, 2);
      highest = std::max(highest, height_m_ + offset);
    }
    storey_m_ = highest + kCeilingSlab_m;
  }

  std::vector<Cell> DrawCells(int count) {
    const v1::Room& main = rooms_[0];
    Cell first = MakeCell(main.kind(), wall_m_, root_.Child("goal", 0));
    first.x = first.y = -wall_m_ / 2;
    first.width = main.width_m() + wall_m_;
    first.depth = main.depth_m() + wall_m_;
    first.fixed_size = true;
    std::vector<Cell> cells = {first};
    const bool two =
        count >= 5 && !main.hall() && root_.Child("storeys").Bernoulli(config_.two_storeys_p());
    if (two) {
      stairs_ = DrawStairs(storey_m_, root_.Child("stairs"));
      Cell stairs;
      stairs.kind = "stairs";
      stairs.both_storeys = stairs.fixed_size = true;
      stairs.width = stairs_.width_m() + 0.1 + wall_m_;
      stairs.depth = kLanding_m + stairs_.length_m() + 0.04 + wall_m_;
      stairs.landing_m = kLanding_m + wall_m_ / 2;
      cells.push_back(stairs);
    }
    const int others = count - static_cast<int>(cells.size());
    int i = 0;
    for (const std::string& kind : DrawKinds(main.kind(), others, root_.Child("kinds"))) {
      cells.push_back(MakeCell(kind, wall_m_, root_.Child("goal", static_cast<uint64_t>(++i))));
    }
    if (two) ChooseStoreys(cells, root_.Child("upstairs"));
    return cells;
  }

  FloorPlan Place(const std::vector<Cell>& cells) const {
    FloorPlan best;
    for (uint64_t k = 0; k < kPlans; ++k) {
      FloorPlan plan = PlaceCells(cells, kPlanSteps, root_.Child("plan", k));
      if (k == 0 || plan.links.unreached < best.links.unreached) best = std::move(plan);
      if (best.links.unreached == 0) break;
    }
    return best;
  }

  void MakeRooms(FloorPlan& plan) {
    DropUnreached(plan);
    std::map<std::string, int> count = {{rooms_[0].kind(), 1}};
    for (size_t i = 1; i < plan.cells.size(); ++i) {
      const Cell& cell = plan.cells[i];
      Rng rng = root_.Child("room", i);
      v1::Room room;
      room.set_kind(cell.kind);
      room.set_name(fmt::format("{}_{}", cell.kind, count[cell.kind]++));
      room.set_origin_x_m(cell.x + wall_m_ / 2);
      room.set_origin_y_m(cell.y + wall_m_ / 2);
      room.set_floor_z_m(cell.storey * storey_m_);
      room.set_width_m(cell.width - wall_m_);
      room.set_depth_m(cell.depth - wall_m_);
      room.set_height_m(std::max(2.3, height_m_ + height_offsets_[i % height_offsets_.size()]));
      if (cell.both_storeys) {
        room.set_height_m(storey_m_ + 2.5);
        *room.mutable_stairs() = stairs_;
      }
      room.set_skirting_height_m(rooms_[0].skirting_height_m());
      room.set_window_glass(config_.window_glass());
      if (rng.Bernoulli(0.4)) room.set_cornice_m(rng.Uniform(0.05, 0.11));
      rooms_.push_back(room);
    }
    // Walls that stand free all along are thicker.
    const double outer = wall_m_ / 2 + 0.1;
    for (size_t i = 0; i < plan.cells.size(); ++i) {
      std::array<bool, 4> shared{};
      for (size_t k = 0; k < plan.cells.size(); ++k) {
        if (i == k) continue;
        const auto contact = TouchOf(plan.cells[i], plan.cells[k]);
        if (contact) shared[static_cast<size_t>(contact->wall_a)] = true;
      }
      rooms_[i].set_wall_thickness_m(outer);
      for (const bool s : shared) rooms_[i].add_wall_depth_m(s ? wall_m_ / 2 : outer);
    }
  }

  static void DropUnreached(FloorPlan& plan) {
    if (plan.links.unreached == 0) return;
    std::vector<bool> in(plan.cells.size(), false);
    in[0] = true;
    for (const auto& [a, b] : plan.links.pairs) in[static_cast<size_t>(b)] = true;
    std::vector<Cell> kept;
    for (size_t i = 0; i < in.size(); ++i) {
      if (in[i]) kept.push_back(plan.cells[i]);
    }
    plan.cells = std::move(kept);
    plan.links = CheapestLinks(plan.cells);
  }

  // The stretch in which both rooms have wall, in the world coordinate along it.
  std::pair<double, double> InnerStretch(const FloorPlan& plan, int a, int b,
                                         const Contact& contact) const {
    double low = contact.low, high = contact.high;
    for (const int i : {a, b}) {
      const Cell& cell = plan.cells[static_cast<size_t>(i)];
      const bool along_x = contact.wall_a % 2 == 0;
      low = std::max(low, (along_x ? cell.x : cell.y) + wall_m_ / 2);
      high = std::min(high, (along_x ? cell.Right() : cell.Top()) - wall_m_ / 2);
    }
    return {low, high};
  }

  void Join(const FloorPlan& plan, int a, int b) {
    const Cell &ca = plan.cells[static_cast<size_t>(a)], &cb = plan.cells[static_cast<size_t>(b)];
    const auto contact = DoorStretch(ca, cb);
    if (!contact) return;
    v1::Room &ra = rooms_[static_cast<size_t>(a)], &rb = rooms_[static_cast<size_t>(b)];
    const auto [low, high] = InnerStretch(plan, a, b, *contact);
    Rng rng = root_.Child("door", static_cast<uint64_t>(a * 16 + b));
    const bool social = LinkCost(ca.kind, cb.kind) < 0.5 && ca.kind != "bathroom" &&
                        cb.kind != "bathroom" && ca.kind != "closet" && cb.kind != "closet" &&
                        ca.kind != "bedroom" && cb.kind != "bedroom" && ca.kind != "office" &&
                        cb.kind != "office";
    const bool passage = rng.Bernoulli(social ? 0.5 : 0);
    v1::Opening door = DrawDoor(ra.height_m() < rb.height_m() ? ra : rb, rng);
    if (passage) {
      door.set_kind(v1::Opening::KIND_PASSAGE);
      door.set_width_m(rng.Uniform(1.0, 2.1));
    }
    OpenUp(config_, ra, rb, root_.Child("open", static_cast<uint64_t>(a * 16 + b)), door);
    const double gap = 0.13;
    door.set_width_m(std::min(door.width_m(), high - low - 2 * gap));
    // On the higher of the two floors.
    const double floor = std::max(ra.floor_z_m(), rb.floor_z_m());
    door.set_sill_m(floor - ra.floor_z_m());
    door.set_depth_m(wall_m_);
    door.set_leads_to(static_cast<uint32_t>(b + 1));
    const double origin_a = contact->wall_a % 2 == 0 ? ra.origin_x_m() : ra.origin_y_m();
    const double origin_b = contact->wall_a % 2 == 0 ? rb.origin_x_m() : rb.origin_y_m();
    const std::vector<WallStretch> stretch = {{contact->wall_a, low - origin_a, high - origin_a}};
    // Two doors may compete for one place of a wall: retry with this and the other room.
    for (int k = 0; k < 12; ++k) {
      v1::Room trial = ra;
      if (!AddOpening(trial, door, stretch, {0.6, gap - 0.001}, rng)) return;
      v1::Opening mate = trial.openings(trial.openings_size() - 1);
      const double world = mate.center_m() + origin_a;
      mate.set_mated(true);
      mate.set_leads_to(static_cast<uint32_t>(a + 1));
      mate.set_sill_m(floor - rb.floor_z_m());
      mate.set_wall(contact->wall_b);
      mate.set_center_m(world - origin_b);
      const bool clear =
          std::none_of(rb.openings().begin(), rb.openings().end(), [&](const v1::Opening& other) {
            const bool level = other.sill_m() < mate.sill_m() + mate.height_m() &&
                               mate.sill_m() < other.sill_m() + other.height_m();
            return other.wall() == mate.wall() && level &&
                   std::abs(other.center_m() - mate.center_m()) <
                       (other.width_m() + mate.width_m()) / 2 + 0.3;
          });
      if (!clear) continue;
      ra = std::move(trial);
      *rb.add_openings() = mate;
      return;
    }
  }

  std::vector<bool> Reached() const {
    std::vector<bool> reached(rooms_.size(), false);
    std::vector<size_t> stack = {0};
    while (!stack.empty()) {
      const size_t r = stack.back();
      stack.pop_back();
      if (reached[r]) continue;
      reached[r] = true;
      for (const v1::Opening& o : rooms_[r].openings()) {
        if (o.leads_to() > 0) stack.push_back(o.leads_to() - 1);
      }
    }
    return reached;
  }

  // Where a wall had no place for the planned door, another wall may.
  void JoinTheRest(const FloorPlan& plan) {
    for (size_t a = 0; a < rooms_.size(); ++a) {
      for (size_t b = 0; b < rooms_.size(); ++b) {
        const std::vector<bool> reached = Reached();
        if (reached[a] && !reached[b]) Join(plan, static_cast<int>(a), static_cast<int>(b));
      }
    }
  }

  // Also connects social rooms that are already connected otherwise.
  void ExtraPassages(const FloorPlan& plan) {
    for (int a = 0; a < static_cast<int>(plan.cells.size()); ++a) {
      for (int b = a + 1; b < static_cast<int>(plan.cells.size()); ++b) {
        const bool linked = std::any_of(plan.links.pairs.begin(), plan.links.pairs.end(),
                                        [&](const std::pair<int, int>& p) {
                                          return p == std::pair(a, b) || p == std::pair(b, a);
                                        });
        const Cell &ca = plan.cells[static_cast<size_t>(a)],
                   &cb = plan.cells[static_cast<size_t>(b)];
        const bool wanted = (ca.kind == "dining_room" || cb.kind == "dining_room" ||
                             ca.kind == "living_room" || cb.kind == "living_room") &&
                            LinkCost(ca.kind, cb.kind) < 0.5;
        if (!linked && wanted) Join(plan, a, b);
      }
    }
  }

  // Parts of the room's walls behind which no other room is.
  std::vector<WallStretch> OpenStretches(const FloorPlan& plan, size_t index) const {
    const Cell& cell = plan.cells[index];
    const v1::Room& room = rooms_[index];
    std::vector<WallStretch> open;
    for (const WallStretch& whole : WholeWalls(room)) {
      std::vector<std::pair<double, double>> taken;
      const double origin = whole.wall % 2 == 0 ? room.origin_x_m() : room.origin_y_m();
      for (size_t k = 0; k < plan.cells.size(); ++k) {
        const auto contact = k == index ? std::nullopt : TouchOf(cell, plan.cells[k]);
        if (contact && contact->wall_a == whole.wall) {
          taken.push_back({contact->low - origin - 0.15, contact->high - origin + 0.15});
        }
      }
      std::sort(taken.begin(), taken.end());
      double from = whole.low_m;
      for (const auto& [a, b] : taken) {
        if (a - from > 0.9) open.push_back({whole.wall, from, a});
        from = std::max(from, b);
      }
      if (whole.high_m - from > 0.9) open.push_back({whole.wall, from, whole.high_m});
    }
    return open;
  }

  void AddOutsideOpenings(const FloorPlan& plan, size_t index) {
    v1::Room& room = rooms_[index];
    const std::vector<WallStretch> open = OpenStretches(plan, index);
    const Rng rng = root_.Child("outside", index);
    const auto hallway = std::find_if(rooms_.begin(), rooms_.end(), [](const v1::Room& r) {
      return r.kind() == "hallway" && r.floor_z_m() == 0;
    });
    const size_t entrance =
        hallway == rooms_.end() ? 0 : static_cast<size_t>(hallway - rooms_.begin());
    if (index == entrance) {
      Rng draw = rng.Child("entrance");
      AddOpening(room, DrawDoor(room, draw), open, {0.5, 0.25}, draw);
    }
    long windows = 1;
    const std::string& kind = room.kind();
    Rng draw = rng.Child("windows");
    const double u = draw.Uniform();
    if (index == 0) {
      windows = std::lround(Draw(config_.windows(), u));
      if (room.hall()) windows *= kHallWindows;
    } else if (kind == "closet" || kind == "stairs" || kind == "hallway") {
      windows = kind != "closet" && u < 0.4;
    } else if (kind == "living_room" || kind == "bedroom" || kind == "dining_room") {
      windows = u < 0.5 ? 1 : 2;
    }
    for (long i = 0; i < windows; ++i) {
      Rng own = rng.Child("window", static_cast<uint64_t>(i));
      v1::Opening window = DrawWindow(room, own);
      // Before the upper half of the stairs, where nobody walks through it.
      if (kind == "stairs") window.set_sill_m(room.stairs().rise_m() + 0.9);
      if (kind == "stairs") window.set_height_m(std::min(window.height_m(), 1.2));
      AddOpening(room, window, open, {0.0, 0.25}, own);
    }
  }

  static void FillReport(const FloorPlan& plan, v1::SolveReport& report) {
    report.set_room("floor plan");
    report.set_steps(plan.steps);
    report.set_accepted(plan.accepted);
    report.set_initial_loss(plan.initial_loss);
    for (const double loss : plan.loss_curve) report.add_loss_curve(loss);
    double total = 0;
    for (const auto& [name, value] : PlanTerms(plan.cells, plan.links)) {
      v1::SolveReport::Constraint& constraint = *report.add_constraints();
      constraint.set_name(name);
      constraint.set_violation(value);
      total += value;
    }
    v1::SolveReport::Constraint& hard = *report.add_constraints();
    hard.set_name("every room can be reached");
    hard.set_hard(true);
    hard.set_violation(plan.links.unreached);
    report.set_final_loss(total);
  }

  const v1::RoomConfig& config_;
  Rng root_;
  std::vector<v1::Room> rooms_;
  std::array<double, 5> height_offsets_{};
  v1::Stairs stairs_;
  double wall_m_ = 0.2, storey_m_ = 3, height_m_ = 2.7;
};

House SingleRoom(const v1::RoomConfig& config, SceneSeed seed, v1::Room room) {
  const Rng root(seed, "layout/room");
  const long doors = std::lround(Draw(config.doors(), root.Child("doors").Uniform()));
  const long drawn = std::lround(Draw(config.windows(), root.Child("windows").Uniform()));
  const long windows = room.hall() ? kHallWindows * drawn : drawn;
  // One wall, rather a long one, has no openings: large furniture stands there. Few rooms have
  // windows on all others, too.
  Rng quiet = root.Child("quiet wall");
  const int longer = room.width_m() >= room.depth_m() ? 0 : 1;
  const int bare = 2 * quiet.UniformInt(0, 1) + (quiet.Bernoulli(0.75) ? longer : 1 - longer);
  const int dark = quiet.Bernoulli(0.6) ? (bare + (quiet.Bernoulli(0.5) ? 1 : 3)) % 4 : bare;
  std::vector<WallStretch> walls, light_walls;
  for (const WallStretch& wall : WholeWalls(room)) {
    if (wall.wall != bare) walls.push_back(wall);
    if (wall.wall != bare && wall.wall != dark) light_walls.push_back(wall);
  }
  for (long i = 0; i < doors; ++i) {
    Rng rng = root.Child("door", static_cast<uint64_t>(i));
    AddOpening(room, DrawDoor(room, rng), walls, {0.6, 0.25}, rng);
  }
  for (long i = 0; i < windows; ++i) {
    Rng rng = root.Child("window", static_cast<uint64_t>(i));
    AddOpening(room, DrawWindow(room, rng), light_walls, {0.0, 0.25}, rng);
  }
  House house;
  house.rooms.push_back(std::move(room));
  return house;
}

}  // namespace

absl::StatusOr<House> DrawHouse(const v1::RoomConfig& config, SceneSeed seed) {
  ASSIGN_OR_RETURN(v1::Room main, DrawMainRoom(config, seed));
  const long count =
      config.has_rooms()
          ? std::lround(Draw(config.rooms(), Rng(seed, "layout/house/rooms").Uniform()))
          : 1;
  House house = count <= 1 ? SingleRoom(config, seed, std::move(main))
                           : HouseBuilder(config, seed, std::move(main))
                                 .Build(static_cast<int>(std::min(count, 8L)));
  for (size_t i = 0; i < house.rooms.size(); ++i) {
    AddPillars(house.rooms[i], Rng(seed, "layout/pillar").Child("room", i));
  }
  return house;
}

}  // namespace parallax
