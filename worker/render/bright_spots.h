// The brightest places of a room's surfaces: the ceiling above a lamp, the wall beside it, a sunlit
// piece of floor. Much of what other surfaces receive comes from these few, and paths that leave by
// chance seldom meet them. They are learnt from the paths that fill the radiance cache; then part
// of all paths leave towards them. Their directions are one part of a mixture with the BSDF's own:
// estimates stay unbiased, whatever was learnt.
//
// Not thread-safe while light is added; queries are.
#pragma once

#include <cstdint>
#include <unordered_map>

#include "common/math/lanes.h"

namespace parallax {

class BrightSpots {
 public:
  static constexpr int kMost = 16;
  static constexpr int kGroups = kMost / kLanes;
  static constexpr float kRadius_m = 0.18f;  // Radius of a sphere around a spot.

  // Light that a surface scatters at a point; luminance.
  void Add(const Vec3f& position, const Vec3f& normal, float radiance);
  // From all that was added so far.
  void Learn();

 private:
  friend class SpotView;
  struct Sum {
    Vec3f positions = Vec3f::Zero(), normals = Vec3f::Zero();
    float radiance = 0, count = 0;
  };

  std::unordered_map<uint64_t, Sum> sums_;  // By cube and facing.
  bool known_ = false;
  // Spots that there are not stand at the origin without strength.
  Vec3x8 center_[kGroups]{}, normal_[kGroups]{};
  Float8 strength_[kGroups]{};  // Luminance times area.
  float rest_ = 0;              // Mean luminance of all other places.
};

// How the spots look from a point of a surface: a cone for each.
class SpotView {
 public:
  SpotView() = default;
  SpotView(const BrightSpots& spots, const Vec3f& position, const Vec3f& normal) {
    Look(spots, position, normal);
  }
  // `normal`: of the surface, on the side that is lit.
  void Look(const BrightSpots& spots, const Vec3f& position, const Vec3f& normal);

  // Part of all paths that should leave towards them.
  float share() const { return share_; }
  // A unit direction into one of the cones; its density is Pdf's. Not without a share.
  Vec3f Sample(float choice, const Vec2f& u) const;
  float Pdf(const Vec3f& direction) const;

 private:
  static constexpr int kGroups = BrightSpots::kGroups;

  float share_ = 0;
  // Only where there is a share.
  float total_;  // Sum of importances.
  Vec3x8 axis_[kGroups];
  Float8 cos_rim_[kGroups];
  Float8 importance_[kGroups];
  Float8 density_[kGroups];  // Chance of a cone over its solid angle.
};

}  // namespace parallax
