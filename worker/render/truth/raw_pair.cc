#include "worker/render/truth/raw_pair.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "worker/render/truth/ground_truth.h"

namespace parallax {
namespace {

// Distances of a view: its rays are unit vectors, so TraceGroundTruth's depth is the distance.
bool IsVisible(const ImageF& distances, const Vec2d& at, double distance) {
  const int width = distances.width(), height = distances.height();
  if (!(at.x() >= 0 && at.y() >= 0 && at.x() < width && at.y() < height)) return false;
  const double cx = at.x() - 0.5, cy = at.y() - 0.5;
  const int x0 = std::clamp(static_cast<int>(std::floor(cx)), 0, width - 1);
  const int y0 = std::clamp(static_cast<int>(std::floor(cy)), 0, height - 1);
  const int x1 = std::min(x0 + 1, width - 1), y1 = std::min(y0 + 1, height - 1);
  const auto near = [&](double d) {
    return d > 0 && std::abs(d - distance) <= kOcclusionThreshold * distance;
  };
  const double d[4] = {distances(x0, y0), distances(x1, y0), distances(x0, y1), distances(x1, y1)};
  if (std::any_of(d, d + 4, near)) return true;
  if (std::any_of(d, d + 4, [](double v) { return v <= 0; })) return false;
  const double u = std::clamp(cx - x0, 0.0, 1.0), v = std::clamp(cy - y0, 0.0, 1.0);
  // The inverse distance is nearly linear along a plane.
  return near(1 / ((1 - v) * ((1 - u) / d[0] + u / d[1]) + v * ((1 - u) / d[2] + u / d[3])));
}

bool ShowsSky(const ImageF& distances, const Vec2d& at) {
  if (!(at.x() >= 0 && at.y() >= 0 && at.x() < distances.width() && at.y() < distances.height())) {
    return false;
  }
  return distances(static_cast<int>(at.x()), static_cast<int>(at.y())) <= 0;
}

void FillView(const PinholeCamera& camera, const PinholeCamera& other, const ImageF& distances,
              const ImageF& other_distances, RawView* view) {
  view->flow = ImageF3(camera.width_px, camera.height_px);
  view->occlusion = ImageU8(camera.width_px, camera.height_px, 255);
  tbb::parallel_for(0, camera.height_px, [&](int y) {
    for (int x = 0; x < camera.width_px; ++x) {
      const Vec2d from(x + 0.5, y + 0.5);
      if (!camera.lens->Sees(from.x(), from.y())) continue;
      const Vec3d ray = camera.world_from_camera * camera.DirectionAt(from.x(), from.y());
      const double distance = distances(x, y);
      const bool surface = distance > 0;
      const Vec3d to = surface ? Vec3d(camera.origin + distance * ray - other.origin) : ray;
      const auto at = other.lens->PointOf(other.world_from_camera.transpose() * to);
      if (!at) continue;
      view->flow(x, y, 0) = static_cast<float>(at->x() - from.x());
      view->flow(x, y, 1) = static_cast<float>(at->y() - from.y());
      view->flow(x, y, 2) = 1;
      const bool visible =
          surface ? IsVisible(other_distances, *at, to.norm()) : ShowsSky(other_distances, *at);
      if (visible) view->occlusion(x, y) = 0;
    }
  });
}

}  // namespace

void BlackenUnseen(const LensRays& lens, ImageF3* radiance) {
  tbb::parallel_for(0, radiance->height(), [&](int y) {
    for (int x = 0; x < radiance->width(); ++x) {
      if (lens.Sees(x + 0.5, y + 0.5)) continue;
      for (int c = 0; c < 3; ++c) (*radiance)(x, y, c) = 0;
    }
  });
}

absl::Status TraceCorrespondence(const RenderScene& scene, const StereoCamera& raw,
                                 const CancelToken& cancel, RawView* left, RawView* right) {
  View truth[2];
  for (int eye = 0; eye < 2; ++eye) {
    RETURN_IF_ERROR(TraceGroundTruth(scene, raw.eyes[eye], raw.baseline_m, cancel, &truth[eye]));
  }
  RawView* views[2] = {left, right};
  for (int eye = 0; eye < 2; ++eye) {
    FillView(raw.eyes[eye], raw.eyes[1 - eye], truth[eye].depth_m, truth[1 - eye].depth_m,
             views[eye]);
  }
  return absl::OkStatus();
}

}  // namespace parallax
