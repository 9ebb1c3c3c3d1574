#include "worker/dataset/sheets/small_pair.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/math/raw_rig.h"

namespace parallax {
namespace {

struct PictureSize {
  int width, height;
};

PictureSize FitSize(int width, int height, int most_width, int most_height) {
  const double scale = std::min(
      {1.0, static_cast<double>(most_width) / width, static_cast<double>(most_height) / height});
  return {std::max(1, static_cast<int>(std::lround(scale * width))),
          std::max(1, static_cast<int>(std::lround(scale * height)))};
}

// The messages Rig and RawCamera have the same names for these fields.
template <typename Camera>
void Resize(Camera& camera, const PictureSize& size) {
  const double x = static_cast<double>(size.width) / camera.width_px();
  const double y = static_cast<double>(size.height) / camera.height_px();
  camera.set_fx_px(x * camera.fx_px());
  camera.set_cx_px(x * camera.cx_px());
  camera.set_fy_px(y * camera.fy_px());
  camera.set_cy_px(y * camera.cy_px());
  camera.set_width_px(size.width);
  camera.set_height_px(size.height);
}

// One eye before rectification.
struct RawEye {
  explicit RawEye(const v1::RawCamera& raw) : camera(FromProto(raw)), reach(camera.lens.Reach()) {}

  // Tangents in the rectified camera's plane; nothing where that looks away.
  std::optional<Vec2d> Rectified(const Vec2d& at_px) const {
    const Vec2d point((at_px.x() - camera.k.cx_px) / camera.k.fx_px,
                      (at_px.y() - camera.k.cy_px) / camera.k.fy_px);
    const auto ray = camera.lens.Unproject(point, reach);
    if (!ray) return std::nullopt;
    const Vec3d turned = camera.rectified_from_raw * *ray;
    if (turned.z() < 0.1) return std::nullopt;
    return Vec2d(turned.head<2>() / turned.z());
  }

  RawIntrinsics camera;
  double reach;
};

}  // namespace

v1::Rig SmallRig(const v1::Rig& rig, int most_width_px, int most_height_px) {
  v1::Rig small = rig;
  const auto fit = [&](const auto& camera) {
    return FitSize(camera.width_px(), camera.height_px(), most_width_px, most_height_px);
  };
  Resize(small, fit(rig));
  if (rig.has_raw_left()) Resize(*small.mutable_raw_left(), fit(rig.raw_left()));
  if (rig.has_raw_right()) Resize(*small.mutable_raw_right(), fit(rig.raw_right()));
  return small;
}

DisparityFigures FiguresOf(const ImageF& disparity_px) {
  DisparityFigures figures;
  std::vector<float> seen;
  for (const float value : disparity_px.values()) {
    if (value > 0) seen.push_back(value);
  }
  if (disparity_px.empty()) return figures;
  figures.share_no_surface =
      1 - static_cast<double>(seen.size()) / static_cast<double>(disparity_px.pixels());
  if (seen.empty()) return figures;
  const auto share = [&](auto&& is_in) {
    return static_cast<double>(std::count_if(seen.begin(), seen.end(), is_in)) /
           static_cast<double>(seen.size());
  };
  figures.share_below_1px = share([](float value) { return value < kLeastUsefulDisparity_px; });
  figures.share_beyond_192px = share([](float value) { return value > kMostTrainedDisparity_px; });
  double sum = 0;
  for (const float value : seen) sum += value;
  figures.mean_px = sum / static_cast<double>(seen.size());
  const auto [min, max] = std::minmax_element(seen.begin(), seen.end());
  figures.min_px = *min;
  figures.max_px = *max;
  const auto middle = seen.begin() + static_cast<std::ptrdiff_t>(seen.size() / 2);
  std::nth_element(seen.begin(), middle, seen.end());
  figures.median_px = *middle;
  return figures;
}

RowFigures RowsOf(const v1::Rig& rig, const v1::Rig& small, const RawView& left) {
  const RawEye eyes[2] = {RawEye(small.raw_left()), RawEye(small.raw_right())};
  const double begin_scale =
      static_cast<double>(rig.raw_left().height_px()) / small.raw_left().height_px();
  const double end_scale =
      static_cast<double>(rig.raw_right().height_px()) / small.raw_right().height_px();
  RowFigures figures;
  double sum_px = 0;
  int64_t pixels = 0;
  for (int y = 0; y < left.flow.height(); ++y) {
    for (int x = 0; x < left.flow.width(); ++x) {
      const float* flow = left.flow.At(x, y);
      if (left.occlusion(x, y) != 0 || flow[2] == 0) continue;
      const Vec2d begin(x + 0.5, y + 0.5), end = begin + Vec2d(flow[0], flow[1]);
      const double apart_px = std::abs(end_scale * end.y() - begin_scale * begin.y());
      sum_px += apart_px;
      ++pixels;
      figures.raw_max_px = std::max(figures.raw_max_px, apart_px);
      const auto from = eyes[0].Rectified(begin), to = eyes[1].Rectified(end);
      if (!from || !to) continue;
      figures.rectified_max_px =
          std::max(figures.rectified_max_px, rig.fy_px() * std::abs(from->y() - to->y()));
    }
  }
  if (pixels > 0) figures.raw_mean_px = sum_px / static_cast<double>(pixels);
  return figures;
}

std::vector<Vec2d> RowInRaw(const v1::Rig& rig, int eye, double y_px) {
  constexpr double kStep_px = 0.5;
  const RawEye raw(eye == 0 ? rig.raw_left() : rig.raw_right());
  std::vector<Vec2d> points;
  for (double x_px = 0; x_px <= rig.width_px(); x_px += kStep_px) {
    const Vec3d direction((x_px - rig.cx_px()) / rig.fx_px(), (y_px - rig.cy_px()) / rig.fy_px(),
                          1);
    const auto point =
        raw.camera.lens.Project(raw.camera.rectified_from_raw.transpose() * direction, raw.reach);
    if (!point) continue;
    points.emplace_back(raw.camera.k.cx_px + raw.camera.k.fx_px * point->x(),
                        raw.camera.k.cy_px + raw.camera.k.fy_px * point->y());
  }
  return points;
}

}  // namespace parallax
