#include "worker/scene/types/nature/ground/scatter.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "common/base/mix_bits.h"

namespace parallax {
namespace {

constexpr float kShadeOfCrown = 0.85f;
// How far a plant in a row strays from its place, in units of the row's width and step.
constexpr float kStray = 0.3f;
constexpr float kParentReach_m = 14;  // Litter lies at most this far from its plant.
// The most tiles that are looked at for the things around other tiles: a second's work.
constexpr double kMostRingTiles = 1e7;

// The draws of one candidate, one after the other.
class Draws {
 public:
  Draws(uint64_t seed, int32_t x, int32_t y, uint32_t k)
      : state_(MixBits(MixBits(seed ^ (static_cast<uint64_t>(static_cast<uint32_t>(x)) << 32 |
                                       static_cast<uint32_t>(y))) +
                       k)) {}
  uint32_t Bits() {
    state_ = MixBits(state_);
    return static_cast<uint32_t>(state_ >> 32);
  }
  float Unit() { return static_cast<float>(Bits() >> 8) * 0x1p-24f; }

 private:
  uint64_t state_;
};

// Candidates per square metre that leave `per_m2` after each has killed smaller ones around it.
// Source: B. Matern, "Spatial Variation", 1960: hard-core process of the second kind, over
// candidates that are independent of each other.
float CandidateDensity(double per_m2, double spacing_m) {
  if (spacing_m <= 0) return static_cast<float>(per_m2);
  const double disc = std::numbers::pi * spacing_m * spacing_m;
  const double killed = std::min(0.93, per_m2 * disc);
  return static_cast<float>(std::round(-std::log1p(-killed) / disc * 1e6) / 1e6);
}

// Calls `add` with the places of a layer's rows whose cells touch `area`.
template <typename Layer, typename Add>
void AlongRows(const Layer& layer, const Box2f& area, const Add& add) {
  const Vec2f across = layer.mask.across(), along(across.y(), -across.x());
  const Vec2f middle = area.center(), half = 0.5f * area.sizes();
  // Returns the first and last cell of that size that the area touches in a direction.
  const auto cells = [&](const Vec2f& direction, float cell_m) {
    const float at = direction.dot(middle), reach = direction.cwiseAbs().dot(half) + cell_m;
    return std::pair(static_cast<int32_t>(std::floor((at - reach) / cell_m)),
                     static_cast<int32_t>(std::ceil((at + reach) / cell_m)));
  };
  const auto [first_row, last_row] = cells(across, layer.mask.rows_m());
  const auto [first, last] = cells(along, layer.step_m);
  for (int32_t row = first_row; row <= last_row; ++row) {
    for (int32_t place = first; place <= last; ++place) {
      Draws draws(layer.seed, place, row, 1);
      if (draws.Unit() >= layer.filled) continue;
      const float aside = kStray * layer.mask.row_width_m() * (draws.Unit() - 0.5f);
      const float ahead = kStray * layer.step_m * (draws.Unit() - 0.5f);
      const Vec2f p = (static_cast<float>(row) * layer.mask.rows_m() + aside) * across +
                      (static_cast<float>(place) * layer.step_m + ahead) * along;
      add(1000.0 * static_cast<double>(p.x()), 1000.0 * static_cast<double>(p.y()), draws);
    }
  }
}

}  // namespace

Tile TileAt(const Vec2f& p) {
  return {static_cast<int32_t>(std::floor(p.y() / kTile_m)),
          static_cast<int32_t>(std::floor(p.x() / kTile_m))};
}

Box2f BoxOf(const Tile& tile) {
  const Vec2f low =
      kTile_m * Vec2f(static_cast<float>(tile.second), static_cast<float>(tile.first));
  return {low, low + Vec2f::Constant(kTile_m)};
}

struct Scatter::Layer {
  std::string name;
  uint64_t seed;
  float density;  // Candidates per square metre.
  float cell_m;
  float empty;  // With spacing: the chance that a cell has no candidate.
  float size_low, size_high;
  bool broken;
  float spacing_m, claim_m, crown_m, near_parents_m;
  bool parent;
  std::vector<float> up_to;  // Sums of weights, the last 1.
  std::vector<uint8_t> shapes;
  MaskOnGround mask;
  // With rows and spacing: from one place to the next in a row, in place of self-thinning; else 0.
  float step_m = 0;
  float filled = 1;  // Share of such places that have a candidate.

  Layer(const v1::Terrain& recipe, const v1::ScatterLayer& layer)
      : name(layer.name()),
        seed(layer.seed()),
        density(CandidateDensity(layer.per_m2(), layer.spacing_m())),
        size_low(static_cast<float>(layer.size_low())),
        size_high(static_cast<float>(layer.size_high())),
        broken(layer.broken()),
        spacing_m(static_cast<float>(layer.spacing_m())),
        claim_m(static_cast<float>(layer.claim_m())),
        crown_m(static_cast<float>(layer.crown_m())),
        near_parents_m(static_cast<float>(layer.near_parents_m())),
        parent(layer.casts_litter()),
        mask(layer.mask()) {
    cell_m = std::clamp(1.0f / std::sqrt(std::max(density, 1e-6f)), 0.2f, 12.0f);
    // Rounded, because exp may differ in its last digits from one library to the next.
    empty = static_cast<float>(std::round(std::exp(-expected()) * 0x1p20f)) * 0x1p-20f;
    if (mask.rows_m() > 0 && spacing_m > 0) {
      step_m = 0.5f * spacing_m * (size_low + size_high);
      spacing_m = 0;
      filled = std::min(1.0f, static_cast<float>(layer.per_m2()) * step_m * mask.row_width_m());
      density = filled / (step_m * mask.rows_m());
    }
    double sum = 0, total = 0;
    for (const double weight : layer.weights()) total += weight;
    for (const double weight : layer.weights()) {
      up_to.push_back(static_cast<float>((sum += weight) / total));
    }
    for (const uint32_t prototype : layer.prototypes()) {
      const uint32_t count = recipe.prototypes(static_cast<int>(prototype)).shapes();
      shapes.push_back(static_cast<uint8_t>(std::max(count, 1u)));
    }
  }

  float expected() const { return density * cell_m * cell_m; }  // Candidates of a cell.

  // Candidates of the cell whose draws these are. Layers without spacing have nearly as many in
  // each cell, which is evener than chance. Where candidates thin each other, evenness would leave
  // too many: two in one place are rarer then than CandidateDensity takes them to be. So their
  // number is drawn. Source: Knuth, "Seminumerical Algorithms", 3.4.1, algorithm Q.
  uint32_t CountIn(Draws& cell) const {
    if (spacing_m <= 0) return static_cast<uint32_t>(expected() + cell.Unit());
    uint32_t count = 0;
    for (float product = cell.Unit(); product > empty; product *= cell.Unit()) ++count;
    return count;
  }

  // Returns the size below which a share `u` of all things lies. It takes only roots, so that all
  // libraries give equal bytes. Source: D. Turcotte, "Fractals and fragmentation", J.
  // Geophys. Res. 91, 1986: a power of 2 to 2.8.
  float SizeOf(float u) const {
    if (!broken) return size_low + (size_high - size_low) * 0.5f * (u + u * u);
    const float ratio = size_low / size_high;
    return size_low / std::sqrt(1 - u * (1 - ratio * ratio));
  }

  // Candidates that are drawn for a tile, those around it included.
  double OfTile() const {
    const double side_m = static_cast<double>(kTile_m) + 2 * static_cast<double>(spread_m());
    return static_cast<double>(density) * side_m * side_m;
  }

  // Places in rows that are looked at for a tile; 0 without steps.
  double PlacesOfTile() const {
    if (step_m <= 0) return 0;
    constexpr double kSpan_m = 1.5 * static_cast<double>(kTile_m);  // More than its diagonal.
    return (kSpan_m / static_cast<double>(step_m) + 3) *
           (kSpan_m / static_cast<double>(mask.rows_m()) + 3);
  }

  // How far it reaches out for others, and others are reached by it.
  float spread_m() const { return spacing_m * size_high; }
  float influence_m() const {
    return std::max({claim_m * size_high, crown_m * size_high, parent ? kParentReach_m : 0.0f});
  }
};

// Things around a tile that matter to a later layer's candidates.
struct Scatter::Influence {
  struct Disc {
    Vec2f middle;
    float radius_m;
  };
  std::vector<Disc> claims, crowns;
  std::vector<Vec2f> parents;

  bool Claimed(const Vec2f& p) const {
    return std::any_of(claims.begin(), claims.end(), [&](const Disc& disc) {
      return (disc.middle - p).squaredNorm() < disc.radius_m * disc.radius_m;
    });
  }
  float Shade(const Vec2f& p) const {
    float light = 1;
    for (const Disc& crown : crowns) {
      const float t = (crown.middle - p).squaredNorm() / (crown.radius_m * crown.radius_m);
      if (t < 1) light *= 1 - kShadeOfCrown * (1 - t * t);
    }
    return 1 - light;
  }
  bool NearParent(const Vec2f& p, float within_m) const {
    return std::any_of(parents.begin(), parents.end(), [&](const Vec2f& parent) {
      return (parent - p).squaredNorm() < within_m * within_m;
    });
  }
};

Scatter::Scatter(const v1::Terrain& recipe, const Terrain& terrain) : terrain_(terrain) {
  for (const v1::ScatterLayer& layer : recipe.layers()) layers_.emplace_back(recipe, layer);
}

Scatter::~Scatter() = default;

// Candidates in `area`, before neighbours thin them.
std::vector<Standing> Scatter::Candidates(const Layer& layer, const Box2f& area) const {
  std::vector<Standing> things;
  if (layer.density <= 0) return things;
  const auto add = [&](double x_mm, double y_mm, Draws& draws) {
    Standing thing;
    thing.x_mm = static_cast<int32_t>(std::lround(x_mm));
    thing.y_mm = static_cast<int32_t>(std::lround(y_mm));
    const Vec2f p = thing.position();
    if ((p.array() < area.min().array()).any() || (p.array() >= area.max().array()).any()) return;
    thing.rank = draws.Bits();
    thing.turn = static_cast<uint16_t>(draws.Bits() >> 16);
    const float size = layer.SizeOf(draws.Unit());
    thing.size = static_cast<uint16_t>(std::min(65535L, std::lround(4096.0f * size)));
    const float which = draws.Unit();
    while (thing.prototype + 1u < layer.up_to.size() && which >= layer.up_to[thing.prototype]) {
      ++thing.prototype;
    }
    thing.shape = static_cast<uint8_t>(draws.Bits() % layer.shapes[thing.prototype]);
    const float chance = draws.Unit();
    const float mask = layer.mask.At(terrain_, p);
    if (mask > 0 && chance < mask) things.push_back(thing);
  };
  if (layer.step_m > 0) {
    AlongRows(layer, area, add);
    return things;
  }
  const double cell_mm = 1000.0 * static_cast<double>(layer.cell_m);
  const auto cell_of = [&](float x) { return static_cast<int32_t>(std::floor(x / layer.cell_m)); };
  for (int32_t y = cell_of(area.min().y()); y <= cell_of(area.max().y()); ++y) {
    for (int32_t x = cell_of(area.min().x()); x <= cell_of(area.max().x()); ++x) {
      Draws of_cell(layer.seed, x, y, 0);
      const uint32_t count = layer.CountIn(of_cell);
      for (uint32_t k = 1; k <= count; ++k) {
        Draws draws(layer.seed, x, y, k);
        const double x_mm = cell_mm * (x + static_cast<double>(draws.Unit()));
        const double y_mm = cell_mm * (y + static_cast<double>(draws.Unit()));
        add(x_mm, y_mm, draws);
      }
    }
  }
  return things;
}

Scatter::Influence Scatter::InfluenceOn(size_t layer, const Tile& tile,
                                        const std::vector<Tiles>& placed) const {
  Influence influence;
  const float spread_m = layers_[layer].spread_m();
  const Box2f box = BoxOf(tile);
  for (size_t earlier = 0; earlier < layer; ++earlier) {
    const Layer& other = layers_[earlier];
    const float reach_m = other.influence_m();
    if (reach_m <= 0) continue;
    const auto ring = static_cast<int32_t>(std::ceil((reach_m + spread_m) / kTile_m));
    const Tiles& all = placed[earlier];
    for (int32_t y = tile.first - ring; y <= tile.first + ring; ++y) {
      const Tile from(y, tile.second - ring);
      auto at = std::lower_bound(all.begin(), all.end(), from,
                                 [](const auto& entry, const Tile& t) { return entry.first < t; });
      for (; at != all.end() && at->first <= Tile(y, tile.second + ring); ++at) {
        for (const Standing& thing : at->second) {
          const Vec2f p = thing.position();
          const float away = std::sqrt(box.squaredExteriorDistance(p)) - spread_m;
          const float claim = other.claim_m * thing.scale(), crown = other.crown_m * thing.scale();
          if (claim > away) influence.claims.push_back({p, claim});
          if (crown > away) influence.crowns.push_back({p, crown});
          if (other.parent && away < kParentReach_m) influence.parents.push_back(p);
        }
      }
    }
  }
  return influence;
}

bool Scatter::Lives(const Layer& layer, const Standing& thing, const Influence& influence) const {
  const Vec2f p = thing.position();
  if (influence.Claimed(p)) return false;
  if (layer.near_parents_m > 0 && !influence.NearParent(p, layer.near_parents_m)) return false;
  if (!layer.mask.needs_shade()) return true;
  // A chance of its own: the mask's has been taken already.
  const float chance = static_cast<float>(MixBits(thing.rank) >> 40) * 0x1p-24f;
  return chance < layer.mask.OfShade(influence.Shade(p));
}

std::vector<Standing> Scatter::PlaceTile(size_t index, const Tile& tile,
                                         const std::vector<Tiles>& placed) const {
  const Layer& layer = layers_[index];
  const Box2f own = BoxOf(tile);
  const Vec2f spread = Vec2f::Constant(layer.spread_m());
  std::vector<Standing> things = Candidates(layer, {own.min() - spread, own.max() + spread});
  if (things.empty()) return things;
  const Influence influence = InfluenceOn(index, tile, placed);
  std::erase_if(things, [&](const Standing& thing) { return !Lives(layer, thing, influence); });
  if (layer.spacing_m <= 0) return things;
  // The larger one's spacing counts; of equal ones the higher rank wins.
  const auto stronger = [](const Standing& a, const Standing& b) {
    return a.size != b.size ? a.size > b.size : a.rank > b.rank;
  };
  std::sort(things.begin(), things.end(),
            [](const Standing& a, const Standing& b) { return a.x_mm < b.x_mm; });
  std::vector<Standing> kept;
  for (size_t i = 0; i < things.size(); ++i) {
    const Standing& thing = things[i];
    const Vec2f p = thing.position();
    if ((p.array() < own.min().array()).any() || (p.array() >= own.max().array()).any()) continue;
    const auto kills = [&](const Standing& other) {
      const float reach = layer.spacing_m * other.scale();
      return stronger(other, thing) && (other.position() - p).squaredNorm() < reach * reach;
    };
    const auto far_mm = static_cast<int32_t>(1000 * spread.x()) + 1;
    bool lives = true;
    for (size_t k = i; lives && k-- > 0 && things[k].x_mm >= thing.x_mm - far_mm;) {
      lives = !kills(things[k]);
    }
    for (size_t k = i + 1; lives && k < things.size() && things[k].x_mm <= thing.x_mm + far_mm;
         ++k) {
      lives = !kills(things[k]);
    }
    if (lives) kept.push_back(thing);
  }
  std::sort(kept.begin(), kept.end(), [](const Standing& a, const Standing& b) {
    return std::tie(a.y_mm, a.x_mm, a.rank) < std::tie(b.y_mm, b.x_mm, b.rank);
  });
  return kept;
}

absl::StatusOr<std::vector<TileSet>> Scatter::WithRings(std::vector<TileSet> tiles) const {
  double visited = 0;
  for (size_t layer = layers_.size(); layer-- > 0;) {
    for (size_t earlier = 0; earlier < layer; ++earlier) {
      const float reach_m = layers_[earlier].influence_m();
      if (reach_m <= 0) continue;
      const auto ring =
          static_cast<int32_t>(std::ceil((reach_m + layers_[layer].spread_m()) / kTile_m));
      visited += static_cast<double>(tiles[layer].size()) * std::pow(2 * ring + 1, 2);
      if (visited > kMostRingTiles) {
        return OutOfRange(
            "terrain: layer \"{}\": things of layer \"{}\" matter to it within {} m; with all "
            "layers {:.0f} million tiles would be looked at, allowed are {:.0f}",
            layers_[layer].name, layers_[earlier].name, reach_m, visited / 1e6,
            kMostRingTiles / 1e6);
      }
      for (const auto& [y, x] : tiles[layer]) {
        for (int32_t dy = -ring; dy <= ring; ++dy) {
          for (int32_t dx = -ring; dx <= ring; ++dx) tiles[earlier].insert({y + dy, x + dx});
        }
      }
    }
  }
  return tiles;
}

absl::Status Scatter::CheckCandidates(const std::vector<TileSet>& tiles) const {
  double candidates = 0, places = 0;
  for (size_t layer = 0; layer < layers_.size(); ++layer) {
    places += layers_[layer].PlacesOfTile() * static_cast<double>(tiles[layer].size());
    if (places > kMostPlaces) {
      return OutOfRange(
          "terrain: layer \"{}\": a place at each {} m of rows {} m apart makes {:.0f} million on "
          "{} tiles of {} m, allowed are {:.0f}",
          layers_[layer].name, layers_[layer].step_m, layers_[layer].mask.rows_m(), places / 1e6,
          tiles[layer].size(), kTile_m, kMostPlaces / 1e6);
    }
    candidates += layers_[layer].OfTile() * static_cast<double>(tiles[layer].size());
    if (candidates <= kMostCandidates) continue;
    return OutOfRange(
        "terrain: layer \"{}\": {:.1f} candidates a square metre on {} tiles of {} m make {:.1f} "
        "million with the layers before it, allowed are {:.0f}",
        layers_[layer].name, layers_[layer].density, tiles[layer].size(), kTile_m, candidates / 1e6,
        kMostCandidates / 1e6);
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::vector<Standing>>> Scatter::Place(
    const std::vector<TileSet>& tiles) const {
  ASSIGN_OR_RETURN(const std::vector<TileSet> asked, WithRings(tiles));
  RETURN_IF_ERROR(CheckCandidates(asked));
  std::vector<Tiles> placed(layers_.size());
  std::vector<std::vector<Standing>> all(layers_.size());
  for (size_t layer = 0; layer < layers_.size(); ++layer) {
    Tiles& own = placed[layer];
    for (const Tile& tile : asked[layer]) own.push_back({tile, {}});
    tbb::parallel_for(size_t{0}, own.size(),
                      [&](size_t i) { own[i].second = PlaceTile(layer, own[i].first, placed); });
    for (const auto& [tile, things] : own) {
      if (!tiles[layer].contains(tile)) continue;
      all[layer].insert(all[layer].end(), things.begin(), things.end());
    }
  }
  return all;
}

}  // namespace parallax
