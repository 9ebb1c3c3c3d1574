#include "worker/render/bright_spots.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "worker/render/sampling.h"

namespace parallax {
namespace {

constexpr float kCube_m = 0.3f;  // A spot is a cube's face.
constexpr float kFewest = 4;     // Looks at a place before it is believed.
// Part of a room's scattered light that the spots must give: with less, looking for them costs more
// than it helps.
constexpr double kLeastLight = 0.07;
constexpr float kMostShare = 0.1f;
constexpr float kLeastShare = 0.02f;  // Less is not worth the looking.

uint64_t KeyOf(const Vec3f& position, const Vec3f& normal) {
  const Eigen::Array3i cube = (position / kCube_m).array().floor().cast<int>();
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  const uint64_t face = static_cast<uint64_t>(2 * axis + (normal[axis] < 0.0f ? 1 : 0));
  const auto part = [](int value) { return static_cast<uint64_t>(value) & 0xfffff; };
  return face << 60 | part(cube.x()) << 40 | part(cube.y()) << 20 | part(cube.z());
}

}  // namespace

void BrightSpots::Add(const Vec3f& position, const Vec3f& normal, float radiance) {
  Sum& sum = sums_[KeyOf(position, normal)];
  sum.positions += position;
  sum.normals += normal;
  sum.radiance += radiance;
  ++sum.count;
}

void BrightSpots::Learn() {
  std::vector<std::pair<float, uint64_t>> places;
  double all = 0;
  for (const auto& [key, sum] : sums_) {
    const float mean = sum.radiance / sum.count;
    all += mean;
    if (sum.count >= kFewest) places.emplace_back(mean, key);
  }
  const size_t count = std::min<size_t>(places.size(), kMost);
  std::partial_sort(places.begin(), places.begin() + static_cast<int64_t>(count), places.end(),
                    std::greater<>());
  strength_.setZero();
  double theirs = 0;
  for (size_t i = 0; i < count; ++i) {
    const Sum& sum = sums_[places[i].second];
    const Vec3f normal = sum.normals.normalized();
    const auto at = static_cast<int>(i);
    for (int axis = 0; axis < 3; ++axis) {
      center_[axis][at] = sum.positions[axis] / sum.count;
      normal_[axis][at] = normal[axis];
    }
    strength_[at] = places[i].first * Square(kCube_m);
    theirs += places[i].first;
  }
  for (int axis = 0; axis < 3; ++axis) {
    center_[axis].tail(kMost - static_cast<int>(count)).setZero();
    normal_[axis].tail(kMost - static_cast<int>(count)).setZero();
  }
  const auto others = static_cast<double>(sums_.size() - count);
  rest_ = others > 0 ? static_cast<float>((all - theirs) / others) : 0.0f;
  known_ = count > 0 && theirs >= kLeastLight * all;
}

SpotView::SpotView(const BrightSpots& spots, const Vec3f& position, const Vec3f& normal) {
  if (!spots.known_) return;
  constexpr float kRadius2 = BrightSpots::kRadius_m * BrightSpots::kRadius_m;
  for (int i = 0; i < 3; ++i) axis_[i] = spots.center_[i] - position[i];
  const Values d2 = axis_[0].square() + axis_[1].square() + axis_[2].square();
  const Values inverse = d2.max(kRadius2).rsqrt();
  for (Values& axis : axis_) axis *= inverse;
  const Values rim = BrightSpots::kRadius_m * inverse;  // Sine of a cone's half angle.
  const Values here = axis_[0] * normal.x() + axis_[1] * normal.y() + axis_[2] * normal.z() + rim;
  const Values there = rim - (axis_[0] * spots.normal_[0] + axis_[1] * spots.normal_[1] +
                              axis_[2] * spots.normal_[2]);
  // Not of what is at hand: any direction may meet it.
  importance_ =
      (d2 > 2.0f * kRadius2)
          .select(spots.strength_ * here.max(0.0f) * there.max(0.0f) * inverse.square(), 0.0f);
  total_ = importance_.sum();
  if (!(total_ > 0.0f)) return;
  const float part = total_ / (total_ + kPi * spots.rest_);
  if (part < kLeastShare) return;
  share_ = std::min(part, kMostShare);
  cos_rim_ = (1.0f - rim.square()).max(0.5f).sqrt();
  density_ = importance_ / ((2.0f * kPi * total_) * (1.0f - cos_rim_));
}

Vec3f SpotView::Sample(float choice, const Vec2f& u) const {
  float left = choice * total_;
  int i = 0, last = 0;
  for (; i < BrightSpots::kMost; ++i) {
    if (importance_[i] <= 0.0f) continue;
    last = i;
    if (left < importance_[i]) break;
    left -= importance_[i];
  }
  const float cosine = 1.0f - u.x() * (1.0f - cos_rim_[last]);
  return ShadingFrame({axis_[0][last], axis_[1][last], axis_[2][last]})
      .ToWorld(DirectionAt(cosine, 2.0f * kPi * u.y()));
}

float SpotView::Pdf(const Vec3f& direction) const {
  const Values cosine =
      axis_[0] * direction.x() + axis_[1] * direction.y() + axis_[2] * direction.z();
  // Directions on the rim may be a rounding outside.
  return (cosine >= cos_rim_ - 3e-7f).select(density_, 0.0f).sum();
}

}  // namespace parallax
