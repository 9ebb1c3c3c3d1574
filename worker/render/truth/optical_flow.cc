#include "worker/render/truth/optical_flow.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <utility>

#include "common/base/status.h"
#include "worker/render/truth/ground_truth.h"

namespace parallax {
namespace {

constexpr double kLeastDepth = 1e-6;  // Behind that a camera has no picture of a point.

// From the neighbour's eye to the pixel's point, moved on; world. Without surface its direction.
Vec3d ToPoint(const View& now, const PinholeCamera& camera, const FlowTarget& target, int x,
              int y) {
  const Vec3d ray = camera.world_from_camera * camera.DirectionAt(x + 0.5, y + 0.5);
  const double depth = static_cast<double>(now.depth_m(x, y));
  if (!(depth > 0)) return ray;
  Vec3d point = camera.origin + depth * ray;
  const auto moved = target.then_from_now.find(now.objects(x, y));
  if (moved != target.then_from_now.end()) point = moved->second * point;
  return point - target.camera.origin;
}

void FillPixel(const View& now, const PinholeCamera& camera, const FlowTarget& target, int x, int y,
               FlowMaps* maps) {
  const PinholeCamera& then = target.camera;
  const Vec3d at = then.world_from_camera.transpose() * ToPoint(now, camera, target, x, y);
  if (!(at.z() > kLeastDepth)) return;
  const double u = then.cx_px + then.fx_px * at.x() / at.z();
  const double v = then.cy_px + then.fy_px * at.y() / at.z();
  float* flow = maps->flow.At(x, y);
  flow[0] = static_cast<float>(u - (x + 0.5));
  flow[1] = static_cast<float>(v - (y + 0.5));
  if (now.depth_m(x, y) > 0) {
    flow[2] = static_cast<float>(target.focal_times_baseline / at.z() -
                                 static_cast<double>(now.disparity_px(x, y)));
  }
  const bool inside = u >= 0 && v >= 0 && u < then.width_px && v < then.height_px;
  maps->occlusion(x, y) = inside ? kFlowVisible : kFlowOccluded;
}

}  // namespace

void FillNoFlow(const PinholeCamera& camera, FlowMaps* maps) {
  maps->flow = ImageF3(camera.width_px, camera.height_px);
  maps->occlusion = ImageU8(camera.width_px, camera.height_px, kFlowNone);
}

void FillFlow(const View& now, const PinholeCamera& camera, const FlowTarget& target,
              FlowMaps* maps) {
  FillNoFlow(camera, maps);
  tbb::parallel_for(0, camera.height_px, [&](int y) {
    for (int x = 0; x < camera.width_px; ++x) FillPixel(now, camera, target, x, y, maps);
  });
}

absl::Status MarkHidden(const RenderScene& then, const View& now, const PinholeCamera& camera,
                        const FlowTarget& target, const CancelToken& cancel, FlowMaps* maps) {
  tbb::parallel_for(0, camera.height_px, [&](int y) {
    if (cancel.cancelled()) return;
    std::array<Sight, kLanes> sights;
    std::array<int, kLanes> columns{};
    size_t count = 0;
    const auto look = [&] {
      LookAt(then, target.camera, std::span(sights).first(count));
      for (size_t k = 0; k < count; ++k) {
        if (sights[k].hidden) maps->occlusion(columns[k], y) = kFlowOccluded;
      }
      count = 0;
    };
    for (int x = 0; x < camera.width_px; ++x) {
      if (maps->occlusion(x, y) != kFlowVisible) continue;
      sights[count] = {ToPoint(now, camera, target, x, y), !(now.depth_m(x, y) > 0), false};
      columns[count++] = x;
      if (count == sights.size()) look();
    }
    if (count > 0) look();
  });
  if (cancel.cancelled()) return Cancelled("render: cancelled");
  return absl::OkStatus();
}

absl::Status TraceOcclusion(const RenderScene& scene, const StereoCamera& stereo,
                            const CancelToken& cancel, StereoFrame* frame) {
  View* views[2] = {&frame->left, &frame->right};
  for (int eye = 0; eye < 2; ++eye) {
    const PinholeCamera& camera = stereo.eyes[eye];
    const FlowTarget other{stereo.eyes[1 - eye], 0, {}};
    FlowMaps maps;
    FillFlow(*views[eye], camera, other, &maps);
    RETURN_IF_ERROR(MarkHidden(scene, *views[eye], camera, other, cancel, &maps));
    views[eye]->exact_occlusion = std::move(maps.occlusion);
  }
  return absl::OkStatus();
}

absl::Status TraceFlow(const RigBook& book, const v1::Rig& rig, const View* kept_left,
                       const RenderScene& scene, MovingScene& moving, const CancelToken& cancel,
                       StereoFrame* frame) {
  ASSIGN_OR_RETURN(const StereoCamera now, StereoCamera::FromRig(rig));
  View* views[2] = {&frame->left, &frame->right};
  for (const auto maps : {&View::forward, &View::backward}) {
    const v1::Rig* neighbour = book.Neighbour(rig, maps == &View::forward);
    if (!neighbour) {
      for (int eye = 0; eye < 2; ++eye) FillNoFlow(now.eyes[eye], &(views[eye]->*maps));
      continue;
    }
    ASSIGN_OR_RETURN(const StereoCamera then, StereoCamera::FromRig(*neighbour));
    RETURN_IF_ERROR(moving.MoveTo(neighbour->time_s()));
    for (int eye = 0; eye < 2; ++eye) {
      const FlowTarget target{then.eyes[eye], then.eyes[eye].fx_px * then.baseline_m,
                              moving.MotionBetween(rig.time_s(), neighbour->time_s())};
      FlowMaps& flow = views[eye]->*maps;
      FillFlow(*views[eye], now.eyes[eye], target, &flow);
      if (eye == 0 && kept_left) {
        flow.occlusion = (kept_left->*maps).occlusion;
        continue;
      }
      RETURN_IF_ERROR(MarkHidden(scene, *views[eye], now.eyes[eye], target, cancel, &flow));
    }
  }
  return moving.MoveTo(rig.time_s());
}

}  // namespace parallax
