// The inside of a tree as sawn surfaces show it: annual rings about a wandering heart, fibres,
// pores, rays and knots, x along the trunk. Shared by boards, planks, parquet and plywood.
#pragma once

#include "worker/materials/kernel/surface.h"

namespace parallax {

// The look of a species' wood.
struct WoodSpecies {
  uint32_t early_srgb = 0, late_srgb = 0;    // Spring wood and the dark line of autumn.
  double ring_low_mm = 2, ring_high_mm = 5;  // Width of a year.
  double ring_contrast = 1;                  // 0 = rings hardly show (beech, maple).
  double late_share = 0.35;                  // Dark share of a year.
  double pores = 0;                          // Dark dashes along the grain (oak, ash, walnut).
  double figure_mm = 4;                      // Wander of the rings, which makes cathedral shapes.
  double knots = 0;                          // Share of 12 cm cells with a knot.
};

// The wood of one tree.
class WoodGrain {
 public:
  struct Point {
    Vec3x8 color;
    Float8 roughness_gain;  // Factor, about 1.
  };

  WoodGrain(Rng& rng, const WoodSpecies& species);
  // Returns the colour at `p_m`, x along the grain. `face` is the unit normal of the cut, which
  // decides how wide a ring appears.
  Point At(const Vec3x8& p_m, const Vec3x8& face, Float8 footprint_m) const;
  // Returns the relief of fibres and pores in metres, about +-0.1 mm; for numbers and duals.
  template <typename Vec>
  RealOf<Vec> HeightAt(const Vec& p_m, Float8 footprint_m) const;

 private:
  Float8 Fold(Float8 x_m) const;
  template <typename Vec>
  RealOf<Vec> Pores(const Vec& p_m, Float8 footprint_m) const;

  Vec3f early_, late_, pore_;
  float ring_m_, contrast_, late_share_, pores_, figure_m_, knots_, streaks_;
  float heart_y_m_, heart_z_m_, tilt_y_, tilt_z_, fold_m_;
  uint32_t seed_;
};

extern template Float8 WoodGrain::HeightAt(const Vec3x8&, Float8) const;
extern template Dual8 WoodGrain::HeightAt(const DualVec8&, Float8) const;

// Draws a finish: oiled, satin or gloss varnish.
struct WoodFinish {
  float roughness, specular, clearcoat, clearcoat_roughness;
  explicit WoodFinish(Rng& rng);
  void Apply(const WoodGrain::Point& grain, SurfaceSample8& out) const;
};

extern const WoodSpecies kOak, kWalnut, kPine, kCherry, kBeech, kMahogany, kAsh, kEbony;

}  // namespace parallax
