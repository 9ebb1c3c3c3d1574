// Beds of hard and soft rock by turns. Where they come to the surface, the ground follows them:
// gentle on soft beds, steep on hard ones, which stand out of faces as ledges. Pure; thread-safe.
#pragma once

#include <cstdint>

#include "worker/terrain/field.h"

namespace parallax {

struct StrataSpec {
  float bed_m = 0;    // Mean thickness of a hard bed and the soft one on it; 0: no strata.
  float step = 0.8f;  // How far the ground follows them: 0 not at all, 1 hard beds are sheer.
  float ledge_m = 0;  // How far hard beds stand out of steep faces.
  float dip = 0;      // Rise over run of the beds towards `dip_rad`.
  float dip_rad = 0;
  uint32_t seed = 0;
};

class Strata {
 public:
  Strata() = default;
  explicit Strata(const StrataSpec& spec) : spec_(spec) {}

  bool any() const { return spec_.bed_m > 0; }
  bool has_ledges() const { return any() && spec_.ledge_m > 0; }
  const StrataSpec& spec() const { return spec_; }

  // Height that ground of this height gets, metres: rises with `height_m`, less than a bed away
  // from it. Nothing changes below debris (in [0, 1]).
  float Stepped(const Vec2f& p, float height_m, float debris) const;
  // How far a steep face at `p` stands out, metres, in [0, ledge_m].
  float Ledge(const Vec3f& p) const;

 private:
  // Where the height lies in the order of beds; an integer at each bed's bottom.
  float Level(const Vec2f& p, float height_m) const;

  StrataSpec spec_;
};

}  // namespace parallax
