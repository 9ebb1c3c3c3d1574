// Rig strategy: views with the largest spread of depth. Private to worker/scene.
#pragma once

#include <limits>

#include "parallax/v1/config.pb.h"
#include "worker/scene/dress.h"
#include "worker/scene/rigs/rig_camera.h"

namespace parallax {

// Figures of one view from probe rays. Depths are along the axis.
struct ViewProbe {
  double nearest_m = std::numeric_limits<double>::infinity();
  double std_m = 0;
  double sky = 0;  // Shares of the probes.
  double one_plane = 0;
  double one_thing = 0;  // The largest share of a single thing of the room.
  double close = 0;
  double near_m = 0;  // A twentieth of the probes is nearer.
  double things = 0;  // Neither a part of the place nor sky.
};

// Probes a view. `camera`: right, down, forward as columns, world. Needs a committed solid twin.
ViewProbe ProbeView(const SceneInProgress& scene, const Vec3f& eye, const Mat3f& camera,
                    const RigCamera& view);

// Returns whether nothing is nearer than `distance` to any point of the segment of this `length`
// from `from` along unit `right`.
bool SegmentClear(const RayScene& solid, const Vec3f& from, const Vec3f& right, float length,
                  float distance);

// Adds the stereo rigs with the largest spread of depth among random candidates. Each rig's height,
// pitch, field of view and baseline are drawn as the config says; only its place and direction are
// chosen, within the surroundings' bounds and above their floor. Requires a committed solid twin.
// Adds fewer than config.count if there are too few free places.
void BestSpreadRigs(const v1::RigConfig& config, SceneInProgress& scene);

}  // namespace parallax
