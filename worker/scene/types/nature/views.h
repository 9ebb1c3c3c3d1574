// The parts of the land that a scene's frames see, in plan view. Constant; thread-safe.
#pragma once

#include <vector>

#include "parallax/v1/scene.pb.h"
#include "worker/scene/types/nature/scatter.h"
#include "worker/terrain/ground_mesh.h"

namespace parallax {

// The views of all rigs.
class Views {
 public:
  // Requires at least one rig.
  explicit Views(const google::protobuf::RepeatedPtrField<v1::Rig>& rigs);

  // Returns the distance in plan from `p` to the nearest eye, metres.
  float Distance(const Vec2f& p) const;
  // Returns whether an object of this radius at `p` may be seen: within `disc_m` of an eye, or in a
  // view and within `reach_m`.
  bool Wants(const Vec2f& p, float radius_m, float disc_m, float reach_m) const;
  // Returns the tiles on which objects may be seen. The arguments are those of Wants.
  TileSet Tiles(float disc_m, float reach_m) const;

  // Returns the views for GroundMesh, with the eyes' heights above the terrain.
  std::vector<ViewCone> Cones(const Terrain& terrain) const;
  float focal_px() const { return focal_px_; }
  // The eyes of each rig, in order of rigs; world, metres.
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
