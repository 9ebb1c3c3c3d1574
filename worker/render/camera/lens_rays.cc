#include "worker/render/camera/lens_rays.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>

namespace parallax {

std::shared_ptr<const LensRays> LensRays::Make(const RawIntrinsics& camera) {
  std::shared_ptr<LensRays> rays(new LensRays(camera));
  const int columns = camera.width_px + 1, rows = camera.height_px + 1;
  rays->corners_.resize(static_cast<size_t>(columns) * static_cast<size_t>(rows));
  std::atomic<bool> whole{true};
  tbb::parallel_for(0, rows, [&](int y) {
    for (int x = 0; x < columns; ++x) {
      if (!rays->Unproject(x, y)) whole = false;
      rays->corners_[static_cast<size_t>(y) * static_cast<size_t>(columns) +
                     static_cast<size_t>(x)] = rays->DirectionAt(x, y).cast<float>();
    }
  });
  rays->whole_ = whole;
  return rays;
}

Vec3d LensRays::DirectionAt(double x, double y) const {
  if (const auto direction = Unproject(x, y)) return *direction;
  const double cx = camera_.k.cx_px, cy = camera_.k.cy_px;
  Vec3d last = Vec3d::UnitZ();
  double low = 0, high = 1;
  for (int i = 0; i < 40; ++i) {
    const double part = (low + high) / 2;
    const auto direction = Unproject(cx + part * (x - cx), cy + part * (y - cy));
    (direction ? low : high) = part;
    if (direction) last = *direction;
  }
  return last;
}

Vec3f LensRays::SampleAt(float x, float y) const {
  const int column = std::clamp(static_cast<int>(x), 0, camera_.width_px - 1);
  const int row = std::clamp(static_cast<int>(y), 0, camera_.height_px - 1);
  const float u = x - static_cast<float>(column), v = y - static_cast<float>(row);
  const auto stride = static_cast<size_t>(camera_.width_px + 1);
  const Vec3f* at = &corners_[static_cast<size_t>(row) * stride + static_cast<size_t>(column)];
  return ((1 - v) * ((1 - u) * at[0] + u * at[1]) + v * ((1 - u) * at[stride] + u * at[stride + 1]))
      .normalized();
}

std::optional<Vec2d> LensRays::PointOf(const Vec3d& direction) const {
  const std::optional<Vec2d> at = camera_.lens.Project(direction, reach_);
  if (!at) return std::nullopt;
  return Vec2d(at->x() * camera_.k.fx_px + camera_.k.cx_px,
               at->y() * camera_.k.fy_px + camera_.k.cy_px);
}

}  // namespace parallax
