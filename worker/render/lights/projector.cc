#include "worker/render/lights/projector.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "common/base/rng.h"
#include "worker/render/surface/sampling.h"

namespace parallax {
namespace {

constexpr double kMargin = 0.12;   // Share of a cell, on each side of a dot.
constexpr float kReachSigmas = 4;  // A Gaussian ends there; 0.03 % of its power lies beyond.
constexpr int kFarthestCell = 3;   // Cells that are searched to each side.

absl::Status CheckProjector(const v1::Projector& p) {
  const auto is_fov = [](double rad) { return rad > 0 && rad < std::numbers::pi; };
  const double sum = p.power_w() + p.place_m() + p.dot_rad();
  if (std::isfinite(sum) && p.power_w() >= 0 && p.dots() >= 0 && p.dot_rad() > 0 &&
      is_fov(p.horizontal_fov_rad()) && is_fov(p.vertical_fov_rad())) {
    return absl::OkStatus();
  }
  return InvalidArgument(
      "projector: wants a power and a number of dots of at least 0, a field of view between 0 and "
      "pi, a dot wider than 0, finite numbers");
}

}  // namespace

absl::StatusOr<DotPattern> DotPattern::Make(const v1::Projector& projector) {
  RETURN_IF_ERROR(CheckProjector(projector));
  DotPattern pattern;
  pattern.half_ = Vec2f(static_cast<float>(std::tan(projector.horizontal_fov_rad() / 2)),
                        static_cast<float>(std::tan(projector.vertical_fov_rad() / 2)));
  pattern.variance_ = Square(static_cast<float>(projector.dot_rad() / 4));
  if (projector.dots() == 0) return pattern;
  pattern.power_w_ = static_cast<float>(projector.power_w() / projector.dots());
  pattern.PlaceDots(projector.seed(), projector.dots());
  return pattern;
}

// As many cells as dots or a few more; which of them are left empty is drawn, too.
void DotPattern::PlaceDots(uint64_t seed, int count) {
  const double aspect = static_cast<double>(half_.x()) / static_cast<double>(half_.y());
  columns_ = std::max(1, static_cast<int>(std::lround(std::sqrt(count * aspect))));
  rows_ = (count + columns_ - 1) / columns_;
  std::vector<int> cells(static_cast<size_t>(columns_) * static_cast<size_t>(rows_));
  std::iota(cells.begin(), cells.end(), 0);
  const Rng root(SceneSeed{seed}, "projector");
  Rng order = root.Child("cells");
  order.Shuffle(cells);
  cells.resize(static_cast<size_t>(count));
  std::sort(cells.begin(), cells.end());
  dot_of_cell_.assign(static_cast<size_t>(columns_) * static_cast<size_t>(rows_), -1);
  Rng places = root.Child("dots");
  for (const int cell : cells) {
    const double x = cell % columns_ + places.Uniform(kMargin, 1 - kMargin);
    const double y = cell / columns_ + places.Uniform(kMargin, 1 - kMargin);
    dot_of_cell_[static_cast<size_t>(cell)] = static_cast<int32_t>(dots_.size());
    dots_.emplace_back(half_.x() * static_cast<float>(2 * x / columns_ - 1),
                       half_.y() * static_cast<float>(2 * y / rows_ - 1));
  }
}

float DotPattern::Intensity(const Vec3f& to, const SampleFootprint& footprint) const {
  if (!(to.z() > 0) || dots_.empty()) return 0;
  const float distance = to.norm();
  const ShadingFrame frame(to / distance);
  // A parallelogram's variance is a twelfth of its sides' squares.
  float xx = variance_, xy = 0, yy = variance_;
  for (const Vec3f* side : {&footprint.across, &footprint.down}) {
    const float u = frame.x.dot(*side) / distance, v = frame.y.dot(*side) / distance;
    xx += u * u / 12;
    xy += u * v / 12;
    yy += v * v / 12;
  }
  const float determinant = xx * yy - xy * xy;
  if (!(determinant > 0)) return 0;
  const float reach = kReachSigmas * std::sqrt(xx + yy);  // At least along the longer axis.
  const Vec2f at(to.x() / to.z(), to.y() / to.z());
  // Bound on an angle's length on the plane z = 1.
  const float stretch = Square(distance / to.z());
  const Vec2f cell((at.x() / half_.x() + 1) / 2 * static_cast<float>(columns_),
                   (at.y() / half_.y() + 1) / 2 * static_cast<float>(rows_));
  const auto cells = [&](float middle, float half, int count, int* first, int* last) {
    const float width = reach * stretch / (2 * half) * static_cast<float>(count);
    const float most = std::min(width, static_cast<float>(kFarthestCell));
    *first = static_cast<int>(std::floor(std::clamp(middle - most, 0.0f, 1e6f)));
    *last =
        std::min(count - 1, static_cast<int>(std::floor(std::clamp(middle + most, -1.0f, 1e6f))));
  };
  int x0, x1, y0, y1;
  cells(cell.x(), half_.x(), columns_, &x0, &x1);
  cells(cell.y(), half_.y(), rows_, &y0, &y1);
  float sum = 0;
  for (int y = y0; y <= y1; ++y) {
    for (int x = x0; x <= x1; ++x) {
      const int32_t dot = dot_of_cell_[static_cast<size_t>(y) * static_cast<size_t>(columns_) +
                                       static_cast<size_t>(x)];
      if (dot < 0) continue;
      const Vec2f& middle = dots_[static_cast<size_t>(dot)];
      const Vec3f off = Vec3f(middle.x(), middle.y(), 1).normalized() - frame.z;
      const float u = frame.x.dot(off), v = frame.y.dot(off);
      const float squared = (yy * u * u - 2 * xy * u * v + xx * v * v) / determinant;
      if (squared < Square(kReachSigmas)) sum += std::exp(-squared / 2);
    }
  }
  return power_w_ * sum / (2 * kPi * std::sqrt(determinant));
}

}  // namespace parallax
