#include "worker/layout/furnish.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/base/rng.h"
#include "worker/layout/anneal/annealer.h"
#include "worker/layout/plan/room_shell.h"
#include "worker/layout/small_things.h"

namespace parallax {
namespace {

constexpr int kFullSteps = 550, kReducedSteps = 60;
// A step of `best` is a step of `full`; how many a second buys is fixed, so that results do not
// depend on the machine. About what one core of 2020 does.
constexpr double kBestStepsPerSecond = 4000;

constexpr double kRoom_m2 = 20;

struct Steps {
  int large = 0, medium = 0, small = 0;
  int runs = 1;
};

// The paper's 550 = 300 + 200 + 50, and the same shares of any number. Greedy additions need more
// of theirs for small things.
Steps StepsOf(const v1::SolverConfig& config, const v1::Room& room) {
  const bool full =
      config.mode() == v1::SolverConfig::MODE_FULL || config.mode() == v1::SolverConfig::MODE_BEST;
  int total = config.steps();
  if (total <= 0) total = full ? kFullSteps : kReducedSteps;
  if (room.hall()) {  // As many more as it is larger than a room.
    total = static_cast<int>(total * std::max(1.0, room.width_m() * room.depth_m() / kRoom_m2));
  }
  Steps steps;
  steps.large = full ? total * 300 / 550 : total * 24 / 60;
  steps.medium = full ? total * 200 / 550 : total * 14 / 60;
  steps.small = total - steps.large - steps.medium;
  if (config.mode() == v1::SolverConfig::MODE_BEST) {
    const double all = config.budget_s() * kBestStepsPerSecond;
    // Splits the steps evenly between longer anneals and more anneals.
    const double longer = std::max(1.0, std::sqrt(all / total));
    steps.large = static_cast<int>(steps.large * longer);
    steps.medium = static_cast<int>(steps.medium * longer);
    steps.runs = std::max(1, static_cast<int>(all / (total * longer)));
  }
  return steps;
}

std::vector<Obstacle> ObstaclesOf(const v1::Room& room) {
  std::vector<Obstacle> obstacles;
  for (const v1::Pillar& pillar : room.pillars()) {
    const double half = pillar.side_m() / 2 + 0.014;
    obstacles.push_back({{{pillar.x_m(), pillar.y_m()}, {half, half}, 0}, 0, room.height_m()});
  }
  if (room.has_stairs()) {
    const v1::Stairs& stairs = room.stairs();
    const double width = room.width_m(), length = stairs.length_m() + 0.05;
    obstacles.push_back({{{width / 2, stairs.landing_m() + length / 2}, {width / 2, length / 2}, 0},
                         0,
                         stairs.rise_m() + 1.2});
    obstacles.push_back(
        {{{width / 2, stairs.landing_m() / 2}, {width / 2, stairs.landing_m() / 2}, 0},
         stairs.rise_m() - 0.3,
         stairs.rise_m() + 1.2});
  }
  return obstacles;
}

bool IsLamp(const PooledAsset& asset) {
  return std::any_of(asset.mesh->slots.begin(), asset.mesh->slots.end(),
                     [](const MaterialSlot& slot) { return slot.emissive; });
}

// Orders anchors before their items, so that a parent is always an earlier entry.
std::vector<int> ParentsFirst(const Arrangement& arrangement) {
  std::vector<int> order;
  std::vector<bool> done(static_cast<size_t>(arrangement.size()), false);
  for (bool more = true; more;) {
    more = false;
    for (int i = 0; i < arrangement.size(); ++i) {
      const Item& item = arrangement.at(i);
      if (item.row < 0 || done[static_cast<size_t>(i)]) continue;
      if (item.anchor >= 0 && !done[static_cast<size_t>(item.anchor)]) continue;
      done[static_cast<size_t>(i)] = true;
      order.push_back(i);
      more = true;
    }
  }
  return order;
}

void FillReport(const AnnealResult& result, const SmallFill& fill, const Steps& steps,
                const std::string& room, v1::SolveReport& report) {
  report.set_room(room);
  report.set_steps((steps.large + steps.medium) * steps.runs + steps.small);
  report.set_accepted(result.accepted + static_cast<int>(fill.things.size()));
  report.set_initial_loss(result.initial_loss);
  report.set_final_loss(result.score.total());
  for (const double loss : result.curve) report.add_loss_curve(loss);
  result.score.Report(report);
  int broken = 0;
  for (int i = 0; i < result.arrangement.size(); ++i) {
    if (result.arrangement.at(i).row >= 0) broken += !result.arrangement.Allowed(i);
  }
  v1::SolveReport::Constraint& hard = *report.add_constraints();
  hard.set_name("in the room, apart, doors and windows free");
  hard.set_hard(true);
  hard.set_violation(broken);
}

}  // namespace

RoomProblem MakeRoomProblem(const v1::Room& room, const RoomTable& table,
                            const v1::AssetConfig& assets, SceneSeed seed) {
  RoomProblem problem;
  problem.room = room;
  problem.room.clear_origin_x_m();
  problem.room.clear_origin_y_m();
  problem.room.clear_floor_z_m();
  problem.strips = StripsOf(room);
  problem.obstacles = ObstaclesOf(room);
  for (int wall = 0; wall < 4; ++wall) {
    problem.walls[static_cast<size_t>(wall)] = FrameOfWall(room, wall);
  }
  const Rng root(seed, "layout/wanted");
  const double area = room.width_m() * room.depth_m();
  for (const RoomRow& row : table.rows) {
    // Large rooms hold more; the tables of halls are for large ones alone.
    const double drawn = root.Child(row.group).Uniform();
    const double u = room.hall() ? drawn : drawn * 0.7 + std::clamp((area - 12) / 20, 0.0, 0.6);
    const int extra = static_cast<int>(u * (row.most - row.least + 1));
    WantedRow wanted{row, std::min(row.least + extra, row.most), {}};
    for (const std::string& name : row.classes) {
      if (ClassAllowed(assets, name)) wanted.classes.push_back(name);
    }
    if (wanted.classes.empty()) wanted.wanted = 0;
    problem.rows.push_back(std::move(wanted));
  }
  return problem;
}

std::vector<Wish> WishesOf(const RoomTable& table) {
  std::vector<Wish> wishes = HouseholdWishes(table);
  wishes.insert(wishes.end(), table.wishes.begin(), table.wishes.end());
  return wishes;
}

std::vector<std::string> PlacedClasses() {
  // Adds table settings, lamps, and the parts of the building itself.
  std::vector<std::string> classes = {
      "Plate", "Fork", "Knife", "Spoon", "Wineglass", "CeilingClassicLamp", "FloorLamp"};
  for (const std::string& name : BuildingClasses()) classes.push_back(name);
  for (const RoomTable& table : RoomTables()) {
    for (const RoomRow& row : table.rows) {
      classes.insert(classes.end(), row.classes.begin(), row.classes.end());
    }
    for (const SmallRow& row : table.small) {
      classes.insert(classes.end(), row.classes.begin(), row.classes.end());
    }
  }
  std::sort(classes.begin(), classes.end());
  classes.erase(std::unique(classes.begin(), classes.end()), classes.end());
  return classes;
}

absl::StatusOr<Furnishing> Furnish(const v1::Room& room, const v1::SceneConfig& config,
                                   const std::vector<Fixture>& fixtures, SceneSeed seed,
                                   AssetPool& pool, const CancelToken& cancel) {
  const RoomTable table = TableOf(room, config.room());
  const Steps steps = StepsOf(config.solver(), room);
  const RoomProblem problem = MakeRoomProblem(room, table, config.assets(), seed);
  const std::vector<Wish> wishes = WishesOf(table);
  const Vec3d origin(room.origin_x_m(), room.origin_y_m(), room.floor_z_m());
  std::vector<Fixture> local = fixtures;
  for (Fixture& fixture : local) fixture.position -= origin;

  const ModelRack rack(seed, pool);
  AnnealPlan plan;
  plan.reduced = config.solver().mode() != v1::SolverConfig::MODE_FULL &&
                 config.solver().mode() != v1::SolverConfig::MODE_BEST;
  plan.large_steps = steps.large;
  plan.medium_steps = steps.medium;
  plan.runs = steps.runs;
  ASSIGN_OR_RETURN(const AnnealResult result,
                   Anneal(problem, wishes, local, rack, plan, seed, cancel));
  ASSIGN_OR_RETURN(const SmallFill fill, FillSupports(result.arrangement, table.small,
                                                      config.assets(), rack, steps.small, seed));

  Furnishing furnishing;
  std::vector<int> entry_of(static_cast<size_t>(result.arrangement.size()), -1);
  const Rng lamps(seed, "layout/lamp");
  for (const int i : ParentsFirst(result.arrangement)) {
    const Item& item = result.arrangement.at(i);
    FurnishedObject object;
    object.asset = item.asset;
    object.position = item.position;
    object.yaw_rad = item.yaw_rad;
    object.relation = NameOf(item.stand);
    if (item.anchor >= 0) object.parent = entry_of[static_cast<size_t>(item.anchor)];
    if (IsLamp(*item.asset)) {
      Rng lamp = lamps.Child(result.arrangement.RowOf(item)->group);
      object.lamp_power_w = LampColor(lamp.Uniform(0, 0.6)) * lamp.Uniform(6, 22);
    }
    entry_of[static_cast<size_t>(i)] = static_cast<int>(furnishing.objects.size());
    furnishing.objects.push_back(object);
  }
  for (const SmallThing& thing : fill.things) {
    furnishing.objects.push_back({thing.asset, thing.position, thing.yaw_rad, "on_top_of",
                                  entry_of[static_cast<size_t>(thing.bearer)], Vec3d::Zero()});
  }
  for (FurnishedObject& object : furnishing.objects) object.position += origin;
  FillReport(result, fill, steps, room.name(), furnishing.report);
  return furnishing;
}

}  // namespace parallax
