#include "worker/render/truth/ground_truth.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>

#include "common/base/status.h"
#include "worker/render/truth/truth_tracer.h"

namespace parallax {
namespace {

bool Visible(const ImageF& other, int row, double x, double z) {
  if (x < 0 || x >= other.width()) return false;
  const int last = other.width() - 1;
  const double c = x - 0.5;
  const int x0 = std::clamp(static_cast<int>(std::floor(c)), 0, last);
  const int x1 = std::min(x0 + 1, last);
  const auto near = [&](double depth) {
    return depth > 0 && std::abs(depth - z) <= kOcclusionThreshold * z;
  };
  const double d0 = other(x0, row);
  const double d1 = other(x1, row);
  if (near(d0) || near(d1)) return true;
  if (d0 <= 0 || d1 <= 0) return false;
  const double t = std::clamp(c - x0, 0.0, 1.0);
  // Disparity, not depth, is linear along a plane.
  return near(1.0 / ((1.0 - t) / d0 + t / d1));
}

}  // namespace

absl::Status TraceGroundTruth(const RenderScene& scene, const PinholeCamera& camera,
                              double baseline_m, const CancelToken& cancel, View* view) {
  const int width = camera.width_px;
  const int height = camera.height_px;
  view->depth_m = ImageF(width, height);
  view->disparity_px = ImageF(width, height);
  view->objects = ImageU16(width, height);
  view->materials = ImageU16(width, height);
  view->normals = ImageF3(width, height);
  view->masks = ImageU8(width, height);
  const TruthTracer tracer(scene, camera);
  const double focal_times_baseline = camera.fx_px * baseline_m;
  tbb::parallel_for(0, height, [&](int y) {
    if (cancel.cancelled()) return;
    std::array<PixelTruth, TruthTracer::kRun> run;
    std::array<SurfaceHit, TruthTracer::kRun> hits;
    for (int x = 0; x < width; ++x) {
      const int k = x % TruthTracer::kRun;
      if (k == 0) tracer.At(x, y, std::min(TruthTracer::kRun, width - x), run.data(), &hits);
      const PixelTruth& truth = run[static_cast<size_t>(k)];
      view->masks(x, y) = truth.mask;
      if (!truth.surface) continue;
      const auto depth = static_cast<float>(truth.depth);
      view->depth_m(x, y) = depth;
      view->disparity_px(x, y) = static_cast<float>(focal_times_baseline / depth);
      view->objects(x, y) = static_cast<uint16_t>(truth.object);
      view->materials(x, y) = static_cast<uint16_t>(truth.material);
      for (int c = 0; c < 3; ++c) view->normals(x, y, c) = truth.normal[c];
    }
  });
  if (cancel.cancelled()) return Cancelled("render: cancelled");
  return absl::OkStatus();
}

void LookAt(const RenderScene& scene, const PinholeCamera& camera, std::span<Sight> sights) {
  TruthTracer(scene, camera).Judge(sights);
}

void MarkOcclusion(View* left, View* right) {
  const int width = left->depth_m.width();
  const int height = left->depth_m.height();
  View* views[2] = {left, right};
  for (int eye = 0; eye < 2; ++eye) {
    View& view = *views[eye];
    const View& other = *views[1 - eye];
    const double sign = eye == 0 ? -1.0 : 1.0;
    view.occlusion = ImageU8(width, height);
    tbb::parallel_for(0, height, [&](int y) {
      for (int x = 0; x < width; ++x) {
        const double z = view.depth_m(x, y);
        const bool visible =
            z > 0 ? Visible(other.depth_m, y, x + 0.5 + sign * view.disparity_px(x, y), z)
                  : other.depth_m(x, y) <= 0;
        view.occlusion(x, y) = visible ? 0 : 255;
      }
    });
  }
}

void MarkVeiled(const Haze& haze, const PinholeCamera& camera, View* view) {
  if (haze.clear()) return;
  const Vec3x8 origin(camera.origin.cast<float>());
  tbb::parallel_for(0, camera.height_px, [&](int y) {
    for (int x = 0; x < camera.width_px; x += kLanes) {
      Vec3x8 to = Vec3x8(Vec3f::UnitZ());
      Float8 depth = Splat(0);
      const int count = std::min(kLanes, camera.width_px - x);
      for (int k = 0; k < count; ++k) {
        const Vec3d along = camera.DirectionAt(x + k + 0.5, y + 0.5);
        to.Set(k, (camera.world_from_camera * along).cast<float>());
        depth[k] = view->depth_m(x + k, y);
      }
      const Float8 length = Norm(to);
      const Float8 passes = haze.Transmittance(origin, to / length, depth * length);
      for (int k = 0; k < count; ++k) {
        if (depth[k] > 0 && passes[k] < 0.05f) view->masks(x + k, y) |= kMaskVeiled;
      }
    }
  });
}

}  // namespace parallax
