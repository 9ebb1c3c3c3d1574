#include "worker/layout/plan/floor_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace parallax {
namespace {

constexpr double kTouch_m = 1e-6;
constexpr double kLeastGap_m = 0.9;
constexpr double kDoorRoom_m = 1.35;  // Shared wall that a door with its casings takes.
constexpr double kWindowRoom_m = 1.5;
constexpr double kHotPlan = 3.0, kColdPlan = 0.01;

bool ShareStorey(const Cell& a, const Cell& b) {
  const auto on = [](const Cell& c, int storey) {
    return c.storey == storey || (c.both_storeys && c.storey + 1 == storey);
  };
  return on(a, b.storey) || on(b, a.storey);
}

bool WantsWindow(const Cell& cell) {
  return cell.kind != "closet" && cell.kind != "hallway" && cell.kind != "stairs" &&
         cell.kind != "bathroom";
}

// Whether two cells overlap or leave a sliver between them.
bool InConflict(const Cell& a, const Cell& b) {
  if (!ShareStorey(a, b)) return false;
  const double gap_x = std::max(a.x - b.Right(), b.x - a.Right());
  const double gap_y = std::max(a.y - b.Top(), b.y - a.Top());
  if (gap_x < -kTouch_m && gap_y < -kTouch_m) return true;
  const double gap = std::max(gap_x, gap_y);
  const bool beside = std::min(gap_x, gap_y) < -kTouch_m;
  return beside && gap > kTouch_m && gap < kLeastGap_m;
}

bool Valid(const std::vector<Cell>& cells, size_t moved) {
  for (size_t i = 0; i < cells.size(); ++i) {
    if (i != moved && InConflict(cells[i], cells[moved])) return false;
  }
  return true;
}

// The longest stretch of the cell's walls that no other covers.
double OpenWall(const std::vector<Cell>& cells, size_t index) {
  const Cell& cell = cells[index];
  double best = 0;
  for (int wall = 0; wall < 4; ++wall) {
    const double low = wall % 2 == 0 ? cell.x : cell.y;
    const double high = wall % 2 == 0 ? cell.Right() : cell.Top();
    std::vector<std::pair<double, double>> taken;
    for (size_t i = 0; i < cells.size(); ++i) {
      if (i == index) continue;
      const auto contact = TouchOf(cell, cells[i]);
      if (contact && contact->wall_a == wall) taken.push_back({contact->low, contact->high});
    }
    std::sort(taken.begin(), taken.end());
    double from = low;
    for (const auto& [a, b] : taken) {
      best = std::max(best, a - from);
      from = std::max(from, b);
    }
    best = std::max(best, high - from);
  }
  return best;
}

double Area(const Cell& cell) { return cell.width * cell.depth; }

// Share of each storey's bounding box that no room fills.
double Waste(const std::vector<Cell>& cells) {
  double waste = 0;
  for (int storey = 0; storey < 2; ++storey) {
    double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9, filled = 0;
    for (const Cell& c : cells) {
      if (c.storey != storey && !(c.both_storeys && c.storey + 1 == storey)) continue;
      x0 = std::min(x0, c.x), y0 = std::min(y0, c.y);
      x1 = std::max(x1, c.Right()), y1 = std::max(y1, c.Top());
      filled += Area(c);
    }
    if (filled > 0) waste += 1 - filled / ((x1 - x0) * (y1 - y0));
  }
  return waste;
}

// Share of the upper rooms' area without a room below.
double Unsupported(const std::vector<Cell>& cells) {
  double total = 0, borne = 0;
  for (const Cell& above : cells) {
    if (above.storey == 0) continue;
    total += Area(above);
    for (const Cell& below : cells) {
      if (below.storey != 0) continue;
      const double w = std::min(above.Right(), below.Right()) - std::max(above.x, below.x);
      const double d = std::min(above.Top(), below.Top()) - std::max(above.y, below.y);
      if (w > 0 && d > 0) borne += w * d;
    }
  }
  return total > 0 ? 1 - borne / total : 0;
}

class Planner {
 public:
  Planner(std::vector<Cell> cells, Rng rng) : cells_(std::move(cells)), rng_(rng) {}

  FloorPlan Run(int steps) {
    Start();
    FloorPlan plan;
    loss_ = Loss(cells_);
    plan.initial_loss = loss_;
    for (int step = 0; step < steps; ++step) {
      const double t = static_cast<double>(step) / std::max(1, steps - 1);
      const double temperature = kHotPlan * std::pow(kColdPlan / kHotPlan, t);
      plan.accepted += Step(temperature, t > 0.85);
      if (step % 32 == 0) plan.loss_curve.push_back(loss_);
    }
    plan.cells = cells_;
    plan.links = CheapestLinks(cells_);
    plan.steps = steps;
    plan.loss_curve.push_back(loss_);
    return plan;
  }

 private:
  static double Loss(const std::vector<Cell>& cells) {
    double loss = 0;
    for (const auto& [name, value] : PlanTerms(cells, CheapestLinks(cells))) loss += value;
    return loss;
  }

  // Starts with all cells in a row: a valid plan.
  void Start() {
    std::array<double, 2> right = {cells_[0].Right(), -1e9};
    for (size_t i = 1; i < cells_.size(); ++i) {
      Cell& cell = cells_[i];
      if (!cell.fixed_size) Reshape(cell);
      auto& edge = right[static_cast<size_t>(cell.storey)];
      if (edge < -1e8) edge = cells_[0].x;
      for (const Cell& other : cells_) {
        if (other.both_storeys && cell.storey == 1) edge = std::max(edge, other.Right());
      }
      cell.x = edge;
      cell.y = cells_[0].y;
      edge = cell.Right();
    }
  }

  void Reshape(Cell& cell) {
    const double aspect = cell.kind == "hallway" ? rng_.Uniform(1.6, 3.6) : rng_.Uniform(1.0, 1.6);
    const double area = cell.goal_m2 * std::exp(rng_.Uniform(-0.25, 0.25));
    const double longer = std::max(cell.least_m, std::sqrt(area * aspect));
    const double shorter = std::max(cell.least_m, area / longer);
    const bool wide = rng_.Bernoulli(0.5);
    cell.width = wide ? longer : shorter;
    cell.depth = wide ? shorter : longer;
  }

  // Puts the cell against a side of another, mostly with aligned edges.
  bool Attach(Cell& cell) {
    std::vector<const Cell*> others;
    for (const Cell& other : cells_) {
      if (&other != &cell && ShareStorey(other, cell)) others.push_back(&other);
    }
    if (others.empty()) return false;
    const Cell& other = *rng_.Pick(others);
    const int side = rng_.UniformInt(0, 3);
    const double u = rng_.Uniform();
    const int align = rng_.UniformInt(0, 3);  // 0, 1: either edge; else free.
    const auto slide = [&](double low, double high, double length) {
      if (align == 0) return low;
      if (align == 1) return high - length;
      const double first = low - length + kDoorRoom_m, last = high - kDoorRoom_m;
      return first + u * std::max(0.0, last - first);
    };
    if (side % 2 == 0) {
      cell.y = side == 0 ? other.y - cell.depth : other.Top();
      cell.x = slide(other.x, other.Right(), cell.width);
    } else {
      cell.x = side == 3 ? other.x - cell.width : other.Right();
      cell.y = slide(other.y, other.Top(), cell.depth);
    }
    return true;
  }

  // Moves one edge of the cell to the line of another cell's edge.
  bool Snap(Cell& cell) {
    if (cell.fixed_size) return false;
    const Cell& other = rng_.Pick(cells_);
    const bool along_x = rng_.Bernoulli(0.5), upper = rng_.Bernoulli(0.5);
    const double line = along_x ? (rng_.Bernoulli(0.5) ? other.x : other.Right())
                                : (rng_.Bernoulli(0.5) ? other.y : other.Top());
    double& from = along_x ? cell.x : cell.y;
    double& length = along_x ? cell.width : cell.depth;
    const double end = from + length;
    if (upper) {
      length = line - from;
    } else {
      from = line;
      length = end - line;
    }
    return length >= cell.least_m;
  }

  bool Step(double temperature, bool greedy) {
    const std::vector<Cell> before = cells_;
    const size_t i =
        1 + static_cast<size_t>(rng_.UniformInt(0, static_cast<int>(cells_.size()) - 2));
    Cell& cell = cells_[i];
    const double u = rng_.Uniform();
    bool good = true;
    size_t other = i;
    if (u < 0.4) {
      if (!cell.fixed_size && rng_.Bernoulli(0.5)) Reshape(cell);
      good = Attach(cell);
    } else if (u < 0.8) {
      good = Snap(cell);
    } else {
      other = 1 + static_cast<size_t>(rng_.UniformInt(0, static_cast<int>(cells_.size()) - 2));
      Cell& b = cells_[other];
      good = other != i && !cell.fixed_size && !b.fixed_size && cell.storey == b.storey;
      if (good) {  // They change places: what is drawn about the kind goes along.
        std::swap(cell.kind, b.kind);
        std::swap(cell.goal_m2, b.goal_m2);
        std::swap(cell.least_m, b.least_m);
        good = std::min(cell.width, cell.depth) >= cell.least_m &&
               std::min(b.width, b.depth) >= b.least_m;
      }
    }
    good = good && Valid(cells_, i) && Valid(cells_, other);
    const double loss = good ? Loss(cells_) : std::numeric_limits<double>::infinity();
    const double chance = rng_.Uniform();
    const double worse = loss - loss_;
    if (good && (worse <= 0 || (!greedy && chance < std::exp(-worse / temperature)))) {
      loss_ = loss;
      return true;
    }
    cells_ = before;
    return false;
  }

  std::vector<Cell> cells_;
  Rng rng_;
  double loss_ = 0;
};

}  // namespace

std::optional<Contact> TouchOf(const Cell& a, const Cell& b) {
  if (!ShareStorey(a, b)) return std::nullopt;
  Contact contact;
  const auto overlap = [&](double a0, double a1, double b0, double b1) {
    contact.low = std::max(a0, b0);
    contact.high = std::min(a1, b1);
    return contact.high - contact.low > kTouch_m;
  };
  const auto same = [](double p, double q) { return std::abs(p - q) < kTouch_m; };
  if (same(a.Right(), b.x) && overlap(a.y, a.Top(), b.y, b.Top())) {
    contact.wall_a = 1, contact.wall_b = 3;
  } else if (same(b.Right(), a.x) && overlap(a.y, a.Top(), b.y, b.Top())) {
    contact.wall_a = 3, contact.wall_b = 1;
  } else if (same(a.Top(), b.y) && overlap(a.x, a.Right(), b.x, b.Right())) {
    contact.wall_a = 2, contact.wall_b = 0;
  } else if (same(b.Top(), a.y) && overlap(a.x, a.Right(), b.x, b.Right())) {
    contact.wall_a = 0, contact.wall_b = 2;
  } else {
    return std::nullopt;
  }
  return contact;
}

std::optional<Contact> DoorStretch(const Cell& a, const Cell& b) {
  auto contact = TouchOf(a, b);
  if (!contact) return std::nullopt;
  const auto limit = [&](const Cell& cell, int wall) {
    if (cell.landing_m <= 0) return;
    if (wall == 2) contact->high = contact->low;
    if (wall % 2 == 1) contact->high = std::min(contact->high, cell.y + cell.landing_m);
  };
  limit(a, contact->wall_a);
  limit(b, contact->wall_b);
  if (contact->high - contact->low < kDoorRoom_m - kTouch_m) return std::nullopt;
  return contact;
}

double LinkCost(const std::string& a, const std::string& b) {
  struct Pair {
    const char *a, *b;
    double cost;
  };
  static constexpr Pair kPairs[] = {
      {"living_room", "dining_room", 0}, {"kitchen", "dining_room", 0},
      {"living_room", "kitchen", 0.4},   {"living_room", "office", 0.8},
      {"bedroom", "closet", 0},          {"bedroom", "bathroom", 0.3},
      {"kitchen", "closet", 0.8},        {"living_room", "bedroom", 1.2},
      {"dining_room", "office", 1.2},    {"bedroom", "office", 1.0},
      {"stairs", "living_room", 0.5},    {"hallway", "hallway", 1.0}};
  if (a == "hallway" || b == "hallway") return a == b ? 1.0 : 0.2;
  for (const Pair& p : kPairs) {
    if ((a == p.a && b == p.b) || (a == p.b && b == p.a)) return p.cost;
  }
  const bool wet = a == "bathroom" || b == "bathroom";
  const bool food = a == "kitchen" || b == "kitchen" || a == "dining_room" || b == "dining_room";
  return wet && food ? 4 : 2;
}

Links CheapestLinks(const std::vector<Cell>& cells) {
  // Prim's tree from the main room. Nobody walks through bathrooms and closets if it can be
  // helped.
  Links links;
  const size_t n = cells.size();
  const auto dead_end = [](const Cell& cell) {
    return cell.kind == "bathroom" || cell.kind == "closet";
  };
  std::vector<bool> in(n, false);
  in[0] = true;
  for (size_t added = 1; added < n; ++added) {
    double best = std::numeric_limits<double>::infinity();
    std::pair<int, int> pair;
    for (size_t i = 0; i < n; ++i) {
      for (size_t k = 0; in[i] && k < n; ++k) {
        if (in[k] || !DoorStretch(cells[i], cells[k])) continue;
        const double cost =
            LinkCost(cells[i].kind, cells[k].kind) + (i > 0 && dead_end(cells[i]) ? 3 : 0);
        if (cost < best) best = cost, pair = {static_cast<int>(i), static_cast<int>(k)};
      }
    }
    if (!std::isfinite(best)) break;
    in[static_cast<size_t>(pair.second)] = true;
    links.pairs.push_back(pair);
    links.cost += best;
  }
  links.unreached = static_cast<int>(std::count(in.begin(), in.end(), false));
  return links;
}

std::vector<std::pair<std::string, double>> PlanTerms(const std::vector<Cell>& cells,
                                                      const Links& links) {
  double light = 0, areas = 0, shapes = 0;
  for (size_t i = 0; i < cells.size(); ++i) {
    const Cell& cell = cells[i];
    if (WantsWindow(cell)) {
      light += (i == 0 ? 4 : 2) * std::max(0.0, 1 - OpenWall(cells, i) / kWindowRoom_m);
    }
    if (i == 0 || cell.fixed_size) continue;
    areas += 1.5 * std::abs(std::log(Area(cell) / cell.goal_m2));
    const double aspect = std::max(cell.width, cell.depth) / std::min(cell.width, cell.depth);
    shapes += 2.0 * std::max(0.0, aspect - (cell.kind == "hallway" ? 4.5 : 1.9));
  }
  return {{"rooms reached", 12.0 * links.unreached},
          {"rooms beside those they belong to", links.cost},
          {"compact outline", 5.0 * Waste(cells)},
          {"walls for windows", light},
          {"areas", areas},
          {"shapes", shapes},
          {"upper rooms stand on lower ones", 6.0 * Unsupported(cells)}};
}

FloorPlan PlaceCells(std::vector<Cell> cells, int steps, Rng rng) {
  return Planner(std::move(cells), rng).Run(steps);
}

}  // namespace parallax
