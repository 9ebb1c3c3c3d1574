// Alternating beds of hard and soft rock. Where they reach the surface, the ground follows them:
// gentle on soft beds, steep on hard ones, which form ledges on faces. Pure; thread-safe.
#pragma once

#include <cstdint>

#include "worker/terrain/field.h"

namespace parallax {

// The beds of a landscape.
struct StrataSpec {
  float bed_m = 0;    // Mean thickness of a hard bed and the soft one on it; 0: no strata.
  float step = 0.8f;  // How far the ground follows them: 0 not at all, 1: hard beds are sheer.
  float ledge_m = 0;  // Reach of hard beds' ledges on steep faces.
  float dip = 0;      // Rise over run of the beds towards `dip_rad`.
  float dip_rad = 0;
  uint32_t seed = 0;
};

// Evaluates the beds.
class Strata {
 public:
  Strata() = default;
  explicit Strata(const StrataSpec& spec) : spec_(spec) {}

  bool any() const { return spec_.bed_m > 0; }
  bool has_ledges() const { return any() && spec_.ledge_m > 0; }
  const StrataSpec& spec() const { return spec_; }

  // Returns the height of the ground after steps by the beds, metres, from its height `height_m`
  // without them. The result increases with `height_m` and differs from it by less than a bed.
  // `debris` in [0, 1] is the share of loose rock, which hides the steps.
  float Stepped(const Vec2f& p, float height_m, float debris) const;
  // Returns the horizontal reach of a ledge on a steep face at `p`, metres, in [0, ledge_m].
  float Ledge(const Vec3f& p) const;

 private:
  // Returns the height in beds; an integer at each bed's bottom.
  float Level(const Vec2f& p, float height_m) const;

  StrataSpec spec_;
};

}  // namespace parallax
