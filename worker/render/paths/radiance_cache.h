// The light that a scene's rough surfaces scatter, learnt once from paths of all its rigs and then
// read by every picture: a path that has scattered widely ends at the next rough surface with the
// radiance that the cache holds there.
//
// The world is cut into cubes (larger far from the rigs). A cell is one surface's part in one cube,
// facing one of six ways, so that the two sides of a thin wall, and objects close together, never
// share light. In foliage the cubes are larger, and all copies of a plant in a cube share a cell,
// because no single leaf is met often enough to be learnt. A cell holds the mean radiance that its
// surface scattered (not emitted) along the paths that met it, from the side that they met; for a
// leaf this includes transmitted light.
//
// CacheBuilder adds records in the order of calls and, within a call, of records, for any number of
// threads: the same records give the same cache, bit for bit. RadianceCache is constant and
// thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/math/lanes.h"
#include "common/math/types.h"
#include "worker/render/paths/cell_table.h"

namespace parallax {

// A place on a surface, seen from the side of `normal`.
struct CachePlace {
  Vec3f position = Vec3f::Zero();
  Vec3f normal = Vec3f::UnitZ();  // Geometric, unit, on the viewer's side.
  uint32_t group = 0;             // RenderScene::CacheGroup: surfaces that share their light.
  uint16_t slot = 0;
  float coarse = 1;  // Width of its cells, in widths of the grid's cells.
};

// The positions and sizes of cells.
class CacheGrid {
 public:
  static constexpr float kFullDetail_m = 5;  // Beyond it from the rigs, cells grow with distance.

  CacheGrid() = default;
  // `eyes` bounds all viewpoints; `cell_m` is the width of cells near them.
  CacheGrid(const Box3f& eyes, float cell_m) : eyes_(eyes), cell_m_(cell_m) {}

  // Returns the width of the grid's cells at a world position, metres.
  float WidthAt(const Vec3f& position) const;
  Float8 WidthAt(const Vec3x8& position) const;
  // Returns the integer coordinates of the cubes of this width that hold eight positions.
  static Vec3x8 CubeOf(const Vec3x8& positions, Float8 width_m);
  // Returns the key of a place's cell among cells of this width; never 0.
  static uint64_t KeyOf(const CachePlace& place, float width_m);
  uint64_t KeyOf(const CachePlace& place) const { return KeyOf(place, WidthOf(place)); }
  float WidthOf(const CachePlace& place) const { return place.coarse * WidthAt(place.position); }
  // Returns the key of a cell. `cube` are its integer coordinates among cubes of this width, `face`
  // is one of six facings.
  static uint64_t KeyOf(const Eigen::Vector3i& cube, uint32_t face, uint32_t group, uint16_t slot,
                        float width_m);

 private:
  Box3f eyes_ = Box3f(Vec3f::Zero(), Vec3f::Zero());
  float cell_m_ = 0.06f;
};

// Queries of up to eight paths: the radiance that each surface scatters towards its path.
struct CacheQuestions8 {
  Vec3x8 position, normal;  // As in CachePlace.
  Int8 group, slot;
  Float8 coarse;
  // In [0, 1): shift the query by up to half a cell along the surface, which hides the cells'
  // edges.
  Float8 jitter_u, jitter_v;
  Float8 widest_m;     // Queries where cells are wider are skipped.
  uint32_t asked = 0;  // The lanes that ask, as bits.
};

// The frozen cache.
class RadianceCache {
 public:
  RadianceCache() = default;

  // Finds the keys of the answers: one for each lane, 0 where it asks nothing. Prefetches the
  // entries.
  void Ask(const CacheQuestions8& questions, uint64_t* keys) const;
  // Returns the radiance that the surface at `place` scatters towards a viewer, for a key that Ask
  // gave there. False when the cache has no answer.
  bool Answer(uint64_t key, const CachePlace& place, Vec3f* radiance) const;

  size_t cells() const { return table_.cells(); }
  size_t bytes() const { return table_.bytes(); }
  bool empty() const { return cells() == 0; }

 private:
  friend class CacheBuilder;
  // An entry takes 8 bytes, because lookups wait for memory.
  struct Entry {
    uint32_t tag = 0;       // 0 = free.
    uint32_t radiance = 0;  // Three mantissas of 9 bits and their exponent.
  };

  CacheGrid grid_;
  FrozenCells<Entry> table_;
};

// Radiance that one path found at one surface.
struct CacheRecord {
  uint64_t key = 0;
  Vec3f radiance = Vec3f::Zero();
  bool rough = true;             // Scattered about alike to all sides.
  Vec3f excess = Vec3f::Zero();  // Radiance cut off as too bright.
  uint64_t region = 0;           // Key of the wide cell around it, over which an excess is spread.

  // Clamps radiance to this luminance. Up to 64 times as much is kept as excess; brighter light is
  // dropped, because a few such paths in a million would light whole parts of a room.
  void Cut(float luminance);
};

// Collects records into cells. Not thread-safe; Add uses all cores itself.
class CacheBuilder {
 public:
  // Records of consecutive paths, sorted into the shards of their cells.
  struct Batch {
    std::array<std::vector<CacheRecord>, CellTable<CacheRecord>::kShards> shards;
    void Add(const CacheRecord& record) {
      shards[CellTable<CacheRecord>::ShardOf(record.key)].push_back(record);
    }
  };

  // Holds at most `max_cells` cells; records of further cells are dropped.
  CacheBuilder(const CacheGrid& grid, size_t max_cells) : grid_(grid), cells_(max_cells) {}

  void Add(const std::vector<Batch>& batches);
  // Makes the cache of cells met at least `min_records` times, nearly always by paths that found
  // them rough. Where many of a cell's records are too bright, the place itself is bright (the
  // inside of a lamp's shade), and nothing is clamped. Rare excess elsewhere is spread over the
  // cell's region in proportion to the cells' other radiance: no energy is lost, blotches vanish,
  // shadows stay dark.
  RadianceCache Freeze(int min_records) const;
  const CacheGrid& grid() const { return grid_; }
  size_t cells() const { return cells_.cells(); }
  size_t bytes() const { return cells_.bytes(); }

 private:
  struct Cell {
    uint64_t key = 0;  // 0 = free.
    uint32_t count = 0;
    uint32_t rough = 0;
    uint32_t cut = 0;  // Records with an excess.
    Vec3f sum = Vec3f::Zero();
    Vec3f excess = Vec3f::Zero();
    uint64_t region = 0;
    bool bright() const;
  };
  void Add(const CacheRecord& record);

  CacheGrid grid_;
  CellTable<Cell> cells_;
};

}  // namespace parallax
