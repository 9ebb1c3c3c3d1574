// The parts of the land that a scene's frames see, on a map. Constant; thread-safe.
#pragma once

#include <vector>

#include "parallax/v1/scene.pb.h"
#include "worker/scene/types/nature/scatter.h"
#include "worker/terrain/ground_mesh.h"

namespace parallax {

class Views {
 public:
  // At least one rig.
  explicit Views(const google::protobuf::RepeatedPtrField<v1::Rig>& rigs);

  // Metres from `p` to the nearest of the eyes, from above.
  float Distance(const Vec2f& p) const;
  // Whether something of this radius at `p` may be seen: within `disc_m` of an eye, or in a view
  // and within `reach_m`.
  bool Wants(const Vec2f& p, float radius_m, float disc_m, float reach_m) const;
  // The tiles on which something may be wanted.
  TileSet Tiles(float disc_m, float reach_m) const;

  // For the ground's mesh. `height`: of the ground at a place.
  std::vector<ViewCone> Cones(const Terrain& terrain) const;
  float focal_px() const { return focal_px_; }
  // The eyes' segments, left to right, in order of rigs.
  struct Eyes {
    Vec3f left, right;
  };
  const std::vector<Eyes>& eyes() const { return eyes_; }

 private:
  struct Cone {
    Vec2f apex, ahead;  // `ahead`: unit.
    float half_rad, sine, cosine;
  };
  std::vector<Cone> cones_;
  std::vector<Eyes> eyes_;
  float focal_px_ = 0;
};

}  // namespace parallax
