// Optical flow and scene flow between frames of a sequence: where each pixel's first hit is in the
// neighbour's picture, and whether it is hidden there. The same question about the pair's other eye
// is exact occlusion. Exact, from ground truth; independent of sampling and denoising.
#pragma once

#include <Eigen/Geometry>
#include <map>

#include "worker/render/camera/camera.h"
#include "worker/render/camera/stereo_frame.h"
#include "worker/render/film/pairing.h"
#include "worker/render/scene/moving_scene.h"

namespace parallax {

// A frame's neighbour as one eye sees it.
struct FlowTarget {
  PinholeCamera camera;
  double focal_times_baseline = 0;
  // How points of moving objects move in the world from this frame's time to the neighbour's, by
  // SceneObject.index. Objects that are not here rest.
  std::map<uint32_t, Eigen::Affine3d> then_from_now;
};

// Computes the flow of both eyes of `rig` to the frames before and after it; where there is no such
// frame, calls FillNoFlow. The views have their ground truth. `scene` is that of `moving`, which is
// at the rig's time before and after. `kept_left`: the left view of a rig with the same left eye,
// whose occlusion is taken over; nullptr: none. Errors: kCancelled; what Embree says.
absl::Status TraceFlow(const RigBook& book, const v1::Rig& rig, const View* kept_left,
                       const RenderScene& scene, MovingScene& moving, const CancelToken& cancel,
                       StereoFrame* frame);

// Fills flow of `maps`, and occlusion as far as no ray is needed: kFlowNone, and kFlowOccluded for
// what leaves the picture; all else is kFlowVisible. `now` has depth, disparity and objects of
// `camera`'s view.
void FillFlow(const View& now, const PinholeCamera& camera, const FlowTarget& target,
              FlowMaps* maps);

// Marks what is hidden in the neighbour. `then` is the scene at the neighbour's time; the rest is
// as FillFlow was given it. A pixel is hidden when the first surface on the line from the
// neighbour's eye to its point is nearer than the point by more than 1 %, or, where it has no
// surface, when that line meets any. Errors: kCancelled.
absl::Status MarkHidden(const RenderScene& then, const View& now, const PinholeCamera& camera,
                        const FlowTarget& target, const CancelToken& cancel, FlowMaps* maps);

// Fills exact_occlusion of both views, which have their ground truth, as MarkHidden judges: the
// other eye takes the neighbour's place. Errors: kCancelled.
absl::Status TraceOcclusion(const RenderScene& scene, const StereoCamera& stereo,
                            const CancelToken& cancel, StereoFrame* frame);

// Fills maps for a missing neighbour: flow 0, kFlowNone.
void FillNoFlow(const PinholeCamera& camera, FlowMaps* maps);

}  // namespace parallax
