// Rock that lies in beds, which upright joints cut into blocks: the surface of pillars and arches.
#pragma once

#include <vector>

#include "common/base/rng.h"
#include "worker/assets/kernel/shape_noise.h"
#include "worker/geometry/mesh.h"

namespace parallax {

// The size of a formation and of what it broke into, in metres.
struct BeddedRockSpec {
  float height_m = 10;
  float thick_m = 2;      // Radius of the formation; blocks are a bit smaller.
  float bed_m = 0.9f;     // Mean thickness of a bed.
  float ledge_m = 0.15f;  // Width over which a ledge or a joint falls off.
};

// Moves a smooth surface in or out: hard beds stand out, soft seams are hollowed, some blocks have
// fallen. Constant after construction.
class BeddedRock {
 public:
  BeddedRock(const BeddedRockSpec& spec, Rng& rng);

  // Returns where the surface's point `p` (z up from the foot) is now; `out`: unit vector, away
  // from the rock's middle.
  Vec3f Worn(const Vec3f& p, const Vec3f& out) const;

 private:
  struct Bed {
    float floor_m, hard;  // `hard`: from -1, a soft seam, to 1.
    uint64_t seed;
  };

  void AddBeds(Rng& rng);
  // How far the surface stands out at `p`, in radii.
  float Relief(const Vec3f& p) const;
  // Returns Relief as if `bed` had no others above and below it.
  float BlockRelief(const Bed& bed, const Vec3f& p) const;

  BeddedRockSpec spec_;
  kernel::Noise noise_;
  Vec2f dip_;              // Slope of the beds.
  std::vector<Bed> beds_;  // By `floor_m`, from below the foot to above the top.
};

}  // namespace parallax
