// Scatters the objects of a recipe's layers on the ground.
//
// Independent of order: whether an object stands depends on its own draws, on the ground, and on
// the objects within some metres, never on the queried part of the land, the order of queries or
// the threads. Each layer's ground is cut into cells; candidate k of cell (x, y) draws from a hash
// of (layer's seed, x, y, k). A candidate lives if its mask lets it, no earlier layer claims the
// place, and no larger candidate of its layer is within the spacing (self-thinning). A layer of
// rows that has a spacing has a place at each step of a row instead, of which each may have a
// candidate.
#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status.h"
#include "parallax/v1/scene.pb.h"
#include "worker/scene/types/nature/rules/masks.h"
#include "worker/terrain/terrain.h"

namespace parallax {

// An object on the ground. All values are rounded before use, so that equal recipes give equal
// bytes.
struct Standing {
  int32_t x_mm = 0, y_mm = 0;  // World.
  uint16_t turn = 0;           // About z, in 2^-16 turns.
  uint16_t size = 1 << 12;     // Scale in 2^-12.
  uint8_t prototype = 0;       // Index in the layer's list.
  uint8_t shape = 0;
  uint32_t rank = 0;  // A random number of its own.

  Vec2f position() const {
    return 0.001f * Vec2f(static_cast<float>(x_mm), static_cast<float>(y_mm));
  }
  float scale() const { return static_cast<float>(size) / 4096.0f; }
  bool operator==(const Standing&) const = default;
};

// Squares of kTile_m a side, by which the land is queried.
using Tile = std::pair<int32_t, int32_t>;  // (y, x), so that order is by rows.
using TileSet = std::set<Tile>;
inline constexpr float kTile_m = 16;
// Return the tile that contains `p`, and the square of a tile; world frame, metres.
Tile TileAt(const Vec2f& p);
Box2f BoxOf(const Tile& tile);

// The most candidates of all layers of a recipe together. Dense meadows seen from fifty walks have
// half of them.
inline constexpr double kMostCandidates = 15e6;
// The most places in rows, with a candidate or without: some seconds' work.
inline constexpr double kMostPlaces = 2e9;

// Evaluates all layers of one recipe.
class Scatter {
 public:
  // Requires a recipe that has passed CheckRules. Both arguments must outlive the object.
  Scatter(const v1::Terrain& recipe, const Terrain& terrain);
  ~Scatter();

  // Returns for each layer all objects on its tiles, tile by tile. `tiles` has one set for each
  // layer. Errors: kOutOfRange, before anything is placed, for more than kMostCandidates or
  // kMostPlaces, and for layers that influence each other over too large a part of the land.
  absl::StatusOr<std::vector<std::vector<Standing>>> Place(const std::vector<TileSet>& tiles) const;

 private:
  struct Layer;
  struct Influence;
  using Tiles = std::vector<std::pair<Tile, std::vector<Standing>>>;  // In order of tiles.

  // Adds to each layer's tiles those around the tiles of later layers, which ask for its things.
  absl::StatusOr<std::vector<TileSet>> WithRings(std::vector<TileSet> tiles) const;
  absl::Status CheckCandidates(const std::vector<TileSet>& tiles) const;
  std::vector<Standing> Candidates(const Layer& layer, const Box2f& area) const;
  Influence InfluenceOn(size_t layer, const Tile& tile, const std::vector<Tiles>& placed) const;
  bool Lives(const Layer& layer, const Standing& thing, const Influence& influence) const;
  std::vector<Standing> PlaceTile(size_t layer, const Tile& tile,
                                  const std::vector<Tiles>& placed) const;

  const Terrain& terrain_;
  std::vector<Layer> layers_;
};

}  // namespace parallax
