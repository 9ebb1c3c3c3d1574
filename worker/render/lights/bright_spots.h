// Learns the brightest places of a room's surfaces: the ceiling above a lamp, the wall beside it, a
// sunlit piece of floor. Much of the light on other surfaces comes from these few places, and BSDF
// sampling seldom hits them. They are learnt from the paths that fill the radiance cache;
// afterwards a part of all paths is sampled towards them. That density is mixed with the BSDF's
// own, so estimates stay unbiased whatever was learnt.
//
// Not thread-safe while light is added; queries are.
#pragma once

#include <cstdint>
#include <unordered_map>

#include "common/math/lanes.h"

namespace parallax {

// Collects scattered light, then holds at most kMost spots.
class BrightSpots {
 public:
  static constexpr int kMost = 16;
  static constexpr int kGroups = kMost / kLanes;
  static constexpr float kRadius_m = 0.18f;  // Radius of a sphere around a spot.

  // Adds light that a surface scatters at a world position, as luminance. `normal`: unit, lit side.
  void Add(const Vec3f& position, const Vec3f& normal, float radiance);
  // Finds the spots in all light added so far.
  void Learn();

 private:
  friend class SpotView;
  struct Sum {
    Vec3f positions = Vec3f::Zero(), normals = Vec3f::Zero();
    float radiance = 0, count = 0;
  };

  std::unordered_map<uint64_t, Sum> sums_;  // By cube and facing.
  bool known_ = false;
  // Unused entries are at the origin with strength 0.
  Vec3x8 center_[kGroups]{}, normal_[kGroups]{};
  Float8 strength_[kGroups]{};  // Luminance times area.
  float rest_ = 0;              // Mean luminance of all other places.
};

// The spots as seen from a point of a surface: one cone of directions for each.
class SpotView {
 public:
  SpotView() = default;
  SpotView(const BrightSpots& spots, const Vec3f& position, const Vec3f& normal) {
    Look(spots, position, normal);
  }
  // `normal`: unit, of the surface, on the side that is lit.
  void Look(const BrightSpots& spots, const Vec3f& position, const Vec3f& normal);

  // The share of all paths that should be sampled towards the spots, in [0, 1].
  float share() const { return share_; }
  // Samples a unit direction in one of the cones, with density Pdf. `choice` and `u` are in [0, 1).
  // Requires share() > 0.
  Vec3f Sample(float choice, const Vec2f& u) const;
  // Density of Sample, per solid angle.
  float Pdf(const Vec3f& direction) const;

 private:
  static constexpr int kGroups = BrightSpots::kGroups;

  float share_ = 0;
  // Set only where share_ > 0.
  float total_;  // Sum of importances.
  Vec3x8 axis_[kGroups];
  Float8 cos_rim_[kGroups];
  Float8 importance_[kGroups];
  Float8 density_[kGroups];  // Chance of a cone over its solid angle.
};

}  // namespace parallax
