// The light that arrives from all sides, by cells of the world, without the sun's disc and lamps:
// learnt once a scene from all its rigs, and read where a path meets a rough surface, in place of
// further rays. It serves open land, where foliage makes rays dear and light varies little over a
// few centimetres.
//
// A cell holds nine spherical harmonics of incoming radiance. Cells grow with the distance from the
// eyes (CacheGrid), and have parents of four and sixteen times their width, so that a cell that few
// records met takes the rest from them. Sources: Ramamoorthi and Hanrahan, "An efficient
// representation for irradiance environment maps", SIGGRAPH 2001; Greger et al., "The irradiance
// volume", IEEE CG&A 1998.
//
// VolumeBuilder adds records in the order of calls and, within a call, of batches, for any number
// of threads: the same records give the same volume, bit for bit. IrradianceVolume is constant and
// thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "worker/render/paths/radiance_cache.h"

namespace parallax {

// Spherical harmonics of incoming radiance at eight points; world frame.
struct IncomingLight8 {
  static constexpr int kTerms = 9;

  std::array<Vec3x8, kTerms> terms;
  Mask8 known;  // Other lanes are undefined.

  // Returns the irradiance on the side of unit `normal`, never below a fiftieth of the mean.
  Vec3x8 Irradiance(const Vec3x8& normal) const;
  // Returns the radiance about unit `direction`, blurred as by a wide gloss.
  Vec3x8 RadianceAbout(const Vec3x8& direction) const;
};

// The frozen volume.
class IrradianceVolume {
 public:
  IrradianceVolume() = default;

  // Finds the light at those of eight points whose `lanes` are set; `jitter`, in widths of a cell,
  // moves them, which hides the cells' edges.
  IncomingLight8 At(const Vec3x8& positions, const Vec3x8& jitter, Mask8 lanes) const;

  size_t cells() const { return table_.cells(); }
  size_t bytes() const { return table_.bytes(); }
  bool empty() const { return cells() == 0; }

 private:
  friend class VolumeBuilder;
  // A cell in a line of the processor's cache: three colours of each term, as half floats.
  struct alignas(64) Entry {
    std::array<uint16_t, 3 * IncomingLight8::kTerms> terms{};
    uint32_t tag = 0;  // 0: free.
  };

  CacheGrid grid_;
  FrozenCells<Entry> table_;
};

// Light that arrived at a place from one of all directions, each as likely.
struct VolumeRecord {
  Vec3f position = Vec3f::Zero();
  Vec3f direction = Vec3f::UnitZ();  // Unit, towards where it comes from.
  Vec3f radiance = Vec3f::Zero();
};

// Collects records into cells. Not thread-safe; Add and Freeze use all cores themselves.
class VolumeBuilder {
 public:
  static constexpr int kLevels = 3;  // Cells, their parents, and those of these.
  // A record's part in one cell.
  struct Part {
    uint64_t key = 0, parent = 0;  // Parent 0: none.
    Vec3f direction, radiance;
  };
  // Records of consecutive looks, sorted into the shards of their cells.
  using Batch = std::array<std::vector<Part>, CellTable<Part>::kShards>;

  // Holds at most `max_cells` cells; records of further cells are dropped.
  VolumeBuilder(const CacheGrid& grid, size_t max_cells) : grid_(grid), cells_(max_cells) {}

  // Returns the key of the cell, of the smallest ones, that holds a position.
  uint64_t KeyAt(const Vec3f& position) const;
  // Adds a record to a batch; thread-safe for different batches.
  void Put(const VolumeRecord& record, Batch* batch) const;
  void Add(const std::vector<Batch>& batches);
  IrradianceVolume Freeze() const;

 private:
  struct Cell {
    uint64_t key = 0, parent = 0;  // Key 0: free.
    float count = 0;
    std::array<float, 3 * IncomingLight8::kTerms> sums{};
  };
  void Add(const Part& part);
  // Returns the cell's means, towards those of its parents where it has few records.
  std::array<float, 3 * IncomingLight8::kTerms> MeansOf(const Cell& cell) const;

  CacheGrid grid_;
  CellTable<Cell> cells_;
};

}  // namespace parallax
