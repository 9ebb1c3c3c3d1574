// The ground that the frames of a landscape see.
#pragma once

#include <vector>

#include "parallax/v1/scene.pb.h"
#include "worker/terrain/terrain.h"

namespace parallax {

// Points of the bare ground, without plants and stones, that rays meet through a grid of pixels of
// the first, middle and last rig. The terrain must outlive it. Constant; thread-safe.
class Sight {
 public:
  // Requires at least one rig.
  Sight(const Terrain& terrain, const google::protobuf::RepeatedPtrField<v1::Rig>& rigs);

  // Returns the median distance from an eye, in metres; 6 km if no ray meets the ground within it.
  double median_m() const { return median_m_; }
  // Returns the share of these points, in [0, 1], from which no ground hides the direction (unit,
  // world); 1 if none exist.
  double SunlitShare(const Vec3d& direction) const;

 private:
  const Terrain& terrain_;
  std::vector<Vec3d> ground_;  // The points that the rays meet.
  double median_m_ = 0;
};

}  // namespace parallax
