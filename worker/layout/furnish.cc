#include "worker/layout/furnish.h"

#include <algorithm>
#include <string>

#include "common/base/rng.h"
#include "worker/layout/annealer.h"
#include "worker/layout/small_things.h"

namespace parallax {
namespace {

constexpr int kFullSteps = 550, kReducedSteps = 60;
// The rest of the steps put small things on what stands there.
constexpr double kFurnitureShare = 0.75, kReducedFurnitureShare = 0.5;

RoomProblem MakeProblem(const v1::Room& room, const RoomTable& table, const v1::AssetConfig& assets,
                        SceneSeed seed) {
  RoomProblem problem;
  problem.room = room;
  problem.strips = StripsOf(room);
  for (int wall = 0; wall < 4; ++wall) {
    problem.walls[static_cast<size_t>(wall)] = FrameOfWall(room, wall);
  }
  const Rng root(seed, "layout/wanted");
  const double area = room.width_m() * room.depth_m();
  for (const RoomRow& row : table.rows) {
    // Large rooms hold more.
    const double u = root.Child(row.group).Uniform() * 0.7 + std::clamp((area - 12) / 20, 0.0, 0.6);
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

std::string RelationOf(const Arrangement& arrangement, const Item& item) {
  switch (arrangement.RowOf(item)->stand) {
    case Stand::kBackToWall:
      return "against_wall";
    case Stand::kCorner:
      return "in_corner";
    case Stand::kOnTop:
      return "on_top_of";
    case Stand::kOnWall:
      return "on_wall";
    case Stand::kAround:
      return "around";
    case Stand::kInFront:
      return "in_front_of";
    case Stand::kBeside:
      return "beside";
    case Stand::kUnder:
      return "under";
    case Stand::kFree:
      return "on_floor";
  }
  return "";
}

bool IsLamp(const PooledAsset& asset) {
  return std::any_of(asset.mesh->slots.begin(), asset.mesh->slots.end(),
                     [](const MaterialSlot& slot) { return slot.emissive; });
}

// Anchors before what stands by them, so that a parent is always an earlier entry.
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

void FillReport(const AnnealResult& result, const SmallFill& fill, int steps,
                v1::SolveReport& report) {
  report.set_steps(steps);
  report.set_accepted(result.accepted + static_cast<int>(fill.things.size()));
  report.set_initial_loss(result.initial_loss);
  report.set_final_loss(result.loss.Total());
  for (const double loss : result.curve) report.add_loss_curve(loss);
  for (int t = 0; t < kLossTerms; ++t) {
    v1::SolveReport::Constraint& constraint = *report.add_constraints();
    constraint.set_name(std::string(NameOf(static_cast<LossTerm>(t))));
    constraint.set_violation(result.loss.terms[static_cast<size_t>(t)]);
  }
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

absl::StatusOr<Furnishing> Furnish(const v1::Room& room, const v1::SceneConfig& config,
                                   const std::vector<Fixture>& fixtures, SceneSeed seed,
                                   AssetPool& pool, const CancelToken& cancel) {
  const RoomTable& table = *FindRoomTable(room.kind());
  const bool reduced = config.solver().mode() != v1::SolverConfig::MODE_FULL;
  int steps = config.solver().steps();
  if (steps <= 0) steps = reduced ? kReducedSteps : kFullSteps;
  const int furniture_steps =
      static_cast<int>(steps * (reduced ? kReducedFurnitureShare : kFurnitureShare));

  const RoomProblem problem = MakeProblem(room, table, config.assets(), seed);
  const ModelRack rack(seed, pool);
  ASSIGN_OR_RETURN(const AnnealResult result,
                   Anneal(problem, fixtures, rack,
                          reduced ? v1::SolverConfig::MODE_REDUCED : v1::SolverConfig::MODE_FULL,
                          furniture_steps, seed, cancel));
  ASSIGN_OR_RETURN(const SmallFill fill,
                   FillSupports(result.arrangement, table.small, config.assets(), rack,
                                steps - furniture_steps, seed));

  Furnishing furnishing;
  std::vector<int> entry_of(static_cast<size_t>(result.arrangement.size()), -1);
  const Rng lamps(seed, "layout/lamp");
  for (const int i : ParentsFirst(result.arrangement)) {
    const Item& item = result.arrangement.at(i);
    FurnishedObject object;
    object.asset = item.asset;
    object.position = item.position;
    object.yaw_rad = item.yaw_rad;
    object.relation = RelationOf(result.arrangement, item);
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
  FillReport(result, fill, steps, furnishing.report);
  return furnishing;
}

}  // namespace parallax
