// The parts of the land that a scene's frames see, in plan view, and the way that the eyes take.
// Constant; thread-safe.
#pragma once

#include <vector>

#include "parallax/v1/scene.pb.h"
#include "worker/scene/types/nature/ground/scatter.h"
#include "worker/terrain/ground_mesh.h"

namespace parallax {

// The views of all rigs: of their rectified cameras, and of raw ones where rigs have them.
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
    Vec3f across;   // Unit, from the left eye to the right one.
    uint32_t path;  // The walk that it belongs to, from 1; 0: a single view.

    // Whether the eyes go on from here to `next`.
    bool WalkOnTo(const Eyes& next) const { return path != 0 && path == next.path; }
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

// The way of both eyes along the walks of a scene. Constant; thread-safe.
class EyeWay {
 public:
  // The right eye's way is that of each rig or, where `baseline_m` is larger than its baseline,
  // everything up to that baseline.
  EyeWay(const Views& views, float baseline_m);

  // Returns whether a ball comes nearer to the way than `distance_m`; world, metres.
  bool Meets(const Vec3f& middle, float radius_m, float distance_m) const;
  // Returns whether `p` is within `distance_m` of the way in plan.
  bool IsWithin(const Vec2f& p, float distance_m) const;

 private:
  struct Segment {
    Vec3f from, to;
  };

  std::vector<Segment> segments_;
  Box3f box_;                 // Around all.
  std::vector<Vec2f> lefts_;  // The left eyes in plan; no point of the way is farther from them
  float from_left_m_ = 0;     // than this.
};

}  // namespace parallax
