#include "worker/layout/anneal/annealer.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "common/base/status.h"

namespace parallax {
namespace {

constexpr uint64_t kModelsPerClass = 3;
constexpr int kModelDraws = 6;
constexpr int kMoveTries = 40;     // Proposals of a move until one keeps the hard constraints.
constexpr double kMakesWay = 2.0;  // Rows of this weight and more may push lighter things out.
constexpr double kHotRoom = 3.0, kColdRoom = 0.001;
constexpr double kGreedyShare = 0.15;

enum class Move { kAdd, kDelete, kResample, kTranslate, kRotate, kSwap, kRelate };

double Clamp01(double x) { return std::clamp(x, 0.0, 1.0); }

// Whether a row is placed in the first stage. Things for which a bearer is there are placed with
// it, so that it does not settle where they have no room (a TV's stand before a window).
bool IsLarge(const RoomRow& row) {
  if (row.stand == Stand::kOnTop && row.weight >= kMakesWay) return true;
  return row.stand != Stand::kOnTop && row.stand != Stand::kOnWall && row.stand != Stand::kCeiling;
}

class Annealer {
 public:
  Annealer(const RoomProblem& problem, const std::vector<Wish>& wishes, const ModelRack& rack,
           Arrangement start, Rng rng)
      : problem_(problem),
        rack_(rack),
        state_(std::move(start)),
        score_(problem, wishes),
        rng_(rng) {
    score_.Reset(state_);
  }

  // Sets whether the next steps also add hanging objects and objects on top of others.
  void SetStage(bool all) { all_rows_ = all; }

  absl::Status Step(double temperature, bool greedy, bool additions_only) {
    const Move move = additions_only ? Move::kAdd : DrawMove();
    // Moves get smaller as the temperature falls.
    const double reach =
        additions_only ? 1.0 : std::clamp(std::sqrt(temperature / kHotRoom), 0.04, 0.6);
    ASSIGN_OR_RETURN(std::optional<Proposal> next, Propose(move, reach));
    if (!next) return absl::OkStatus();
    const double worse = score_.Try(next->state, next->touched) - score_.total();
    const double chance = rng_.Uniform();
    if (worse < 0 || (!greedy && chance < std::exp(-worse / temperature))) {
      state_ = std::move(next->state);
      score_.Accept();
      ++accepted_;
    }
    return absl::OkStatus();
  }

  const Arrangement& state() const { return state_; }
  const Score& score() const { return score_; }
  int accepted() const { return accepted_; }

 private:
  struct Proposal {
    Arrangement state;
    Touched touched;
  };

  Move DrawMove() {
    bool lacking = false;
    for (size_t r = 0; r < problem_.rows.size(); ++r) {
      if (!all_rows_ && !IsLarge(problem_.rows[r].row)) continue;
      lacking |= state_.CountOf(static_cast<int>(r)) < problem_.rows[r].wanted;
    }
    const double u = rng_.Uniform(), add = lacking ? 0.5 : 0.05;
    if (u < add) return Move::kAdd;
    const double rest = (u - add) / (1 - add);
    if (rest < 0.07) return Move::kDelete;
    if (rest < 0.17) return Move::kResample;
    if (rest < 0.62) return Move::kTranslate;
    if (rest < 0.80) return Move::kRotate;
    if (rest < 0.90) return Move::kRelate;
    return Move::kSwap;
  }

  // The first of a few random changes of this kind that keeps the hard constraints.
  absl::StatusOr<std::optional<Proposal>> Propose(Move move, double reach) {
    for (int k = 0; k < kMoveTries; ++k) {
      Proposal next{state_, {}};
      removed_.clear();
      ASSIGN_OR_RETURN(std::vector<int> changed, Change(move, reach, next.state));
      if (move == Move::kAdd && k >= 2 * kMoveTries / 3 && changed.size() == 1) {
        RETURN_IF_ERROR(TakeAnchorElsewhere(next.state, changed));
      }
      if (move == Move::kAdd && k >= kMoveTries / 3 && changed.size() == 1) {
        // Lighter items make way for one that finds no place.
        next.state = MakeWay(next.state, changed[0]);
        const int added = next.state.size() - 1;
        if (!next.state.Place(added) || !next.state.Allowed(added)) continue;
        for (const Item& item : removed_) next.touched.Add(item);
        next.touched.Add(next.state.at(added));
        return std::optional<Proposal>(std::move(next));
      }
      bool good = !changed.empty() || !removed_.empty();
      for (const int item : changed) good = good && next.state.Place(item);
      for (const int item : changed) good = good && next.state.Allowed(item);
      if (!good) continue;
      // Touches the old and new places of items.
      for (const Item& item : removed_) next.touched.Add(item);
      for (const int item : changed) {
        for (const int i : next.state.WithDependants(item)) {
          next.touched.Add(next.state.at(i));
          if (i < state_.size()) next.touched.Add(state_.at(i));
        }
      }
      return std::optional<Proposal>(std::move(next));
    }
    return std::optional<Proposal>();
  }

  // An item that finds no place by its anchor moves the anchor elsewhere, with all that stands by
  // it; every other time in another model.
  absl::Status TakeAnchorElsewhere(Arrangement& next, std::vector<int>& changed) {
    const int anchor = next.at(changed[0]).anchor;
    if (anchor < 0 || next.at(anchor).row < 0 || next.at(anchor).anchor >= 0) {
      return absl::OkStatus();
    }
    if (!RowOf(next.at(anchor)).row.one_model && rng_.Bernoulli(0.5)) {
      ASSIGN_OR_RETURN(const PooledAsset* other, rack_.Draw(RowOf(next.at(anchor)), rng_));
      if (other != nullptr) next.at(anchor).asset = other;
    }
    DrawTurn(next.at(anchor));
    next.at(anchor).u = rng_.Uniform();
    next.at(anchor).v = rng_.Uniform();
    Aim(next, next.at(anchor));
    changed.insert(changed.begin(), anchor);
    return absl::OkStatus();
  }

  // Returns the arrangement with its last item and without lighter items in its way, or unchanged
  // where that does not help.
  Arrangement MakeWay(const Arrangement& with, int added) {
    Arrangement placed = with;
    const double weight = RowOf(with.at(added)).row.weight;
    if (weight < kMakesWay || !placed.Place(added)) return with;
    const auto blockers = placed.InTheWayOf(added);
    if (!blockers || blockers->empty()) return with;
    double lost = 0;
    std::vector<int> gone;
    for (const int b : *blockers) {
      for (const int i : placed.WithDependants(b)) {
        if (placed.at(i).row < 0 || i == added || i == placed.at(added).anchor) return with;
        if (std::find(gone.begin(), gone.end(), i) != gone.end()) continue;
        gone.push_back(i);
        lost += RowOf(placed.at(i)).row.weight;
      }
    }
    if (lost >= weight) return with;
    std::sort(gone.rbegin(), gone.rend());
    for (const int i : gone) removed_.push_back(placed.at(i));
    for (const int i : gone) {
      const int before = placed.size();
      placed.Remove(i);
      // Something that stands by it was added before it: too tangled to undo.
      if (placed.size() != before - 1) {
        removed_.clear();
        return with;
      }
    }
    return placed;
  }

  // Makes the change; returns the items to be placed again. Empty: nothing to do (or a deletion).
  absl::StatusOr<std::vector<int>> Change(Move move, double reach, Arrangement& next) {
    switch (move) {
      case Move::kAdd:
        return AddItem(next);
      case Move::kDelete: {
        const int item = PickItem(next);
        if (item < 0) return std::vector<int>();
        for (const int i : next.WithDependants(item)) removed_.push_back(next.at(i));
        next.Remove(item);
        return std::vector<int>();
      }
      case Move::kResample: {
        const int i = PickItem(next);
        if (i < 0 || RowOf(next.at(i)).row.one_model) return std::vector<int>();
        ASSIGN_OR_RETURN(next.at(i).asset, rack_.Draw(RowOf(next.at(i)), rng_));
        if (next.at(i).asset == nullptr) return std::vector<int>();
        return std::vector<int>{i};
      }
      case Move::kTranslate: {
        const int i = PickItem(next);
        if (i < 0) return std::vector<int>();
        next.at(i).u = Clamp01(next.at(i).u + rng_.Normal(0, reach));
        next.at(i).v = Clamp01(next.at(i).v + rng_.Normal(0, reach));
        return std::vector<int>{i};
      }
      case Move::kRotate: {
        const int i = PickItem(next);
        if (i < 0) return std::vector<int>();
        DrawTurn(next.at(i));
        const Stand stand = next.at(i).stand;
        if (stand == Stand::kBackToWall || stand == Stand::kOnWall) next.at(i).u = rng_.Uniform();
        Aim(next, next.at(i));
        return std::vector<int>{i};
      }
      case Move::kSwap:
        return SwapItems(next);
      case Move::kRelate:
        return Relate(next);
    }
    return std::vector<int>();
  }

  absl::StatusOr<std::vector<int>> AddItem(Arrangement& next) {
    // Rows that lack items come first, by their weight.
    std::vector<double> weight(problem_.rows.size(), 0);
    double total = 0;
    for (size_t r = 0; r < problem_.rows.size(); ++r) {
      const WantedRow& row = problem_.rows[r];
      const int count = next.CountOf(static_cast<int>(r));
      const bool lacking = count < row.wanted;
      if (!all_rows_ && !IsLarge(row.row)) continue;
      if (count >= row.row.most || row.classes.empty()) continue;
      if (!row.row.anchor.empty() && Anchors(next, static_cast<int>(r)).empty()) continue;
      weight[r] = row.row.weight * (lacking ? 1.0 : 0.02);
      total += weight[r];
    }
    if (total <= 0) return std::vector<int>();
    double u = rng_.Uniform() * total;
    size_t r = 0;
    while (r + 1 < weight.size() && u >= weight[r]) u -= weight[r++];
    if (weight[r] <= 0) return std::vector<int>();
    Item item;
    item.row = static_cast<int>(r);
    ASSIGN_OR_RETURN(item.asset, rack_.Draw(problem_.rows[r], rng_));
    if (item.asset == nullptr) return std::vector<int>();
    item.u = rng_.Uniform();
    item.v = rng_.Uniform();
    item.stand = DrawStand(problem_.rows[r].row);
    if (item.stand == Stand::kOnTop) {  // Rather in the middle than at the edge.
      item.u = Clamp01(rng_.Normal(0.5, 0.16));
      item.v = Clamp01(rng_.Normal(0.4, 0.2));
    }
    if (HasAnchor(problem_.rows[r].row, item.stand)) {
      item.anchor = rng_.Pick(Anchors(next, item.row));
    }
    DrawTurn(item);
    Aim(next, item);
    return std::vector<int>{next.Add(item)};
  }

  // Every other time, proposes an item with a target where it sees it: at the opposite wall, or
  // around it.
  void Aim(const Arrangement& next, Item& item) {
    const RoomRow& row = RowOf(item).row;
    if (row.looks_at.empty() || rng_.Bernoulli(0.4)) return;
    for (const Item& target : next.items()) {
      const RoomRow* found = next.RowOf(target);
      if (found == nullptr || found->group != row.looks_at) continue;
      if (item.stand == Stand::kFree) {
        const double angle = rng_.Uniform(-std::numbers::pi, std::numbers::pi);
        const double reach = rng_.Uniform(0.9, 1.5);
        const Vec2d at = target.footprint.center + reach * Vec2d(std::cos(angle), std::sin(angle));
        item.u = Clamp01(at.x() / problem_.room.width_m());
        item.v = Clamp01(at.y() / problem_.room.depth_m());
        // Its front, +y turned by the yaw, points back at the target.
        item.side = 0;
        item.turn_rad = angle + std::numbers::pi / 2 + rng_.Uniform(-0.2, 0.2);
      } else if (target.stand == Stand::kBackToWall && item.stand == Stand::kBackToWall) {
        item.side = (target.side + 2) % 4;
        item.u = Clamp01(1 - target.u + rng_.Normal(0, 0.1));
      }
      return;
    }
  }

  std::vector<int> SwapItems(Arrangement& next) {
    const int a = PickItem(next), b = PickItem(next);
    if (a < 0 || a == b) return {};
    Item &p = next.at(a), &q = next.at(b);
    const Stand stand = p.stand;
    if (stand != q.stand) return {};
    if (stand != Stand::kBackToWall && stand != Stand::kOnWall && stand != Stand::kCorner)
      return {};
    std::swap(p.side, q.side);
    std::swap(p.u, q.u);
    return {a, b};
  }

  // Chooses another relation that the row allows, or another anchor.
  std::vector<int> Relate(Arrangement& next) {
    const int i = PickItem(next);
    if (i < 0) return {};
    Item& item = next.at(i);
    const RoomRow& row = RowOf(item).row;
    if (row.or_stand.empty() && row.anchor.empty()) return {};
    item.stand = DrawStand(row);
    item.anchor = -1;
    if (HasAnchor(row, item.stand)) {
      const std::vector<int> anchors = Anchors(next, item.row);
      if (anchors.empty()) return {};
      item.anchor = rng_.Pick(anchors);
      if (item.anchor == i) return {};
    }
    item.u = rng_.Uniform();
    item.v = rng_.Uniform();
    DrawTurn(item);
    Aim(next, item);
    return {i};
  }

  Stand DrawStand(const RoomRow& row) {
    if (row.or_stand.empty()) return row.stand;
    const int k = rng_.UniformInt(0, static_cast<int>(row.or_stand.size()));
    return k == 0 ? row.stand : row.or_stand[static_cast<size_t>(k - 1)];
  }

  // Whether an item of this relation has an anchor; with the alternative of a wall, it stands by
  // itself.
  static bool HasAnchor(const RoomRow& row, Stand stand) {
    return !row.anchor.empty() && stand == row.stand;
  }

  // Items of the group that the row stands by, without a child of the row where one is enough.
  std::vector<int> Anchors(const Arrangement& next, int row) const {
    const RoomRow& wanted = problem_.rows[static_cast<size_t>(row)].row;
    const bool several = wanted.stand == Stand::kAround || wanted.stand == Stand::kBeside;
    std::vector<int> anchors;
    for (int i = 0; i < next.size(); ++i) {
      const RoomRow* found = next.RowOf(next.at(i));
      if (found == nullptr || found->group != wanted.anchor) continue;
      if (several || !next.HasChild(i, row)) anchors.push_back(i);
    }
    return anchors;
  }

  void DrawTurn(Item& item) {
    const RoomRow& row = RowOf(item).row;
    item.side = rng_.UniformInt(0, 3);
    const double jitter = rng_.Uniform(-1, 1);
    switch (item.stand) {
      case Stand::kAround:
        item.turn_rad = 0.12 * jitter;
        break;
      case Stand::kInFront:
        item.turn_rad = row.faces_anchor ? 0.3 * jitter : 0.02 * jitter;
        break;
      case Stand::kFree:
        // Tables are square to the walls; items with a target turn to it.
        item.turn_rad = row.looks_at.empty() ? 0 : jitter * std::numbers::pi / 4;
        break;
      case Stand::kCorner:
        item.turn_rad = row.snug ? 0 : 0.3 * jitter;
        break;
      case Stand::kOnTop:
        item.turn_rad = 0.12 * jitter;
        break;
      case Stand::kUnder:
        item.turn_rad = 0.03 * jitter;
        break;
      default:
        item.turn_rad = 0;
    }
  }

  int PickItem(const Arrangement& next) {
    std::vector<int> movable;
    for (int i = 0; i < next.size(); ++i) {
      if (next.at(i).row >= 0) movable.push_back(i);
    }
    return movable.empty() ? -1 : rng_.Pick(movable);
  }

  const WantedRow& RowOf(const Item& item) const {
    return problem_.rows[static_cast<size_t>(item.row)];
  }

  const RoomProblem& problem_;
  const ModelRack& rack_;
  Arrangement state_;
  Score score_;
  Rng rng_;
  std::vector<Item> removed_;  // By the change in hand.
  bool all_rows_ = false;
  int accepted_ = 0;
};

}  // namespace

absl::StatusOr<const PooledAsset*> ModelRack::Draw(const WantedRow& row, Rng& rng) const {
  Rng fixed = root_.Child("set/" + row.row.group);
  Rng& from = row.row.one_model ? fixed : rng;
  const PooledAsset* asset = nullptr;
  for (int k = 0; k < kModelDraws; ++k) {
    const std::string& class_name = from.Pick(row.classes);
    const int model = from.UniformInt(0, static_cast<int>(kModelsPerClass) - 1);
    ASSIGN_OR_RETURN(asset, Get(class_name, static_cast<uint64_t>(model)));
    if (static_cast<double>(asset->bounds.sizes().z()) <= row.row.highest_m) return asset;
  }
  return nullptr;
}

absl::StatusOr<const PooledAsset*> ModelRack::Get(const std::string& class_name,
                                                  uint64_t model) const {
  return pool_->Get(class_name, root_.Child(class_name, model).Seed());
}

absl::StatusOr<AnnealResult> Anneal(const RoomProblem& problem, const std::vector<Wish>& wishes,
                                    const std::vector<Fixture>& fixtures, const ModelRack& rack,
                                    const AnnealPlan& plan, SceneSeed seed,
                                    const CancelToken& cancel) {
  std::optional<AnnealResult> best;
  const Rng root(seed, "layout/anneal");
  const int steps = plan.large_steps + plan.medium_steps;
  for (int run = 0; run < std::max(1, plan.runs); ++run) {
    Annealer annealer(problem, wishes, rack, Arrangement(problem, fixtures),
                      run == 0 ? root : root.Child("run", static_cast<uint64_t>(run)));
    const double initial = annealer.score().total();
    std::vector<double> curve;
    for (int step = 0; step < steps; ++step) {
      if (step % 16 == 0 && cancel.cancelled()) return Cancelled("layout: cancelled");
      const double t = steps > 1 ? static_cast<double>(step) / (steps - 1) : 1;
      const double temperature = kHotRoom * std::pow(kColdRoom / kHotRoom, t);
      annealer.SetStage(step >= plan.large_steps);
      RETURN_IF_ERROR(
          annealer.Step(temperature, plan.reduced || t > 1 - kGreedyShare, plan.reduced));
      curve.push_back(annealer.score().total());
    }
    if (best && best->score.total() <= annealer.score().total()) continue;
    best.emplace(AnnealResult{annealer.state(), annealer.score(), annealer.accepted(), initial,
                              std::move(curve)});
  }
  return *std::move(best);
}

}  // namespace parallax
