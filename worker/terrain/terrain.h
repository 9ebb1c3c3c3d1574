// The ground of a landscape: forms (terms.h) eroded by water and gravity (erosion.h) at two scales,
// with the queries of plants and materials.
//
// The region (some kilometres) is eroded by streams on a coarse raster; the site in its middle,
// where the walk goes, also by rain and gravity on a fine one. Between samples the ground has
// detail of every wavelength down to centimetres, rougher on steep ground. Beyond the region the
// uneroded terms continue to the horizon, and the Earth's curvature lowers them.
//
// Constant after MakeTerrain; thread-safe. The same spec gives the same bits on every machine of
// one build.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "worker/terrain/erosion.h"
#include "worker/terrain/field.h"
#include "worker/terrain/snow.h"
#include "worker/terrain/strata.h"
#include "worker/terrain/terms.h"
#include "worker/terrain/water.h"

namespace parallax {

// All parameters of the ground.
struct TerrainSpec {
  uint64_t seed = 0;
  std::vector<TerrainTerm> terms;
  float region_m = 8192;  // Side of the coarse square; 16 m a cell.
  int region_samples = 513;
  float site_m = 1536;  // Side of the fine square; 1.5 m a cell.
  int site_samples = 1025;
  StreamPowerOptions streams;  // On the region.
  DropletOptions rain;         // On the site; its seed is drawn from the spec's.
  ThermalOptions gravity;      // On both.
  float roughness = 1;         // Factor on the detail between samples; 0: none.
  std::optional<WaterSpec> water;
  // Terms that are not eroded; they keep their edges at every scale.
  std::vector<TerrainTerm> cover;
  StrataSpec strata;
  SnowSpec snow;
};

// The ground as functions of world positions in plan.
class Terrain {
 public:
  // Returns the height at `p`, metres, world z, without detail shorter than `footprint_m`. Includes
  // the Earth's curvature. Continuous in `p`.
  float Height(const Vec2f& p, float footprint_m) const;
  // Returns the slope (d/dx, d/dy) of Height by central differences over the footprint.
  Vec2f Slope(const Vec2f& p, float footprint_m) const;
  // Returns how far ledges of hard beds reach out of steep ground at `p` and height `height_m`,
  // horizontally, metres. Only faces on which nothing stands have ledges.
  float Ledge(const Vec2f& p, float height_m) const;
  bool has_ledges() const { return strata_.has_ledges(); }

  const TerrainSpec& spec() const { return spec_; }
  // Returns the raster of the site; beyond it, masks fade to those of the region.
  const Field& site() const { return site_; }
  const Field& region() const { return region_; }
  // Heights of the site with everything that lies on the eroded ground.
  const Field& surface() const { return surface_.size > 0 ? surface_ : site_; }
  float DrainageArea(const Vec2f& p) const;  // Square metres.
  float Wetness(const Vec2f& p) const;       // [0, 1]: 1 in valley bottoms.
  // Thickness of loose material (scree, sediment), metres.
  float Deposit(const Vec2f& p) const;
  // Steepness of the rasters, without detail: rise over run.
  float Steepness(const Vec2f& p) const;
  // Returns the water; null if none exists.
  const Water* water() const { return water_ ? &*water_ : nullptr; }
  // Returns the height of the ground above the water's still level, negative under water; kDry far
  // from it.
  float AboveWater(const Vec2f& p) const;
  static constexpr float kDry = 1000;
  float SnowDepth(const Vec2f& p) const;  // Metres.

 private:
  friend Terrain MakeTerrain(const TerrainSpec& spec);

  float Base(const Vec2f& p) const;
  // Returns the height including cover and strata on the eroded ground; `loose`: debris in [0, 1].
  float Covered(const Vec2f& p, float eroded_m, float footprint_m, float* loose = nullptr) const;
  void AddCover(Field& height, Field& deposit) const;
  float Detail(const Vec2f& p, float footprint_m) const;
  // Returns the share of bedrock that stands out of a slope at `p`, [0, 1].
  float Outcrop(const Vec2f& p) const;
  // Returns 1 inside a field, 0 at its border and beyond, with a smooth band between.
  static float Weight(const Field& field, const Vec2f& p);
  float Blend(const Field& site, const Field& region, const Vec2f& p) const;

  TerrainSpec spec_;
  std::optional<Water> water_;
  uint32_t detail_seed_ = 0;
  Field region_, site_;
  Field region_area_, site_area_;
  Field region_wetness_, site_wetness_;
  Field region_deposit_, site_deposit_;
  Field region_steepness_, site_steepness_;
  Field region_snow_, site_snow_;  // Empty: none.
  Field surface_;                  // Empty: as site_.
  Strata strata_;
};

// Makes the ground: about 2 core-seconds with the default rasters. Requires rasters of at least 16
// samples and a site that lies within the region.
Terrain MakeTerrain(const TerrainSpec& spec);

}  // namespace parallax
