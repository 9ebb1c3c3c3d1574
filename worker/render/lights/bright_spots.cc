#include "worker/render/lights/bright_spots.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "worker/render/surface/sampling.h"

namespace parallax {
namespace {

constexpr float kSpotCube_m = 0.3f;  // A spot is a cube's face.
constexpr float kFewest = 4;         // Records of a place before it counts.
// Share of a room's scattered light that the spots must have: with less, sampling them costs more
// than it helps.
constexpr double kLeastLight = 0.08;
constexpr float kMostShare = 0.1f;
constexpr float kLeastShare = 0.02f;  // A smaller share is not worth sampling.

uint64_t KeyOf(const Vec3f& position, const Vec3f& normal) {
  const Eigen::Array3i cube = (position / kSpotCube_m).array().floor().cast<int>();
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
  for (int group = 0; group < kGroups; ++group) {
    center_[group] = normal_[group] = Vec3x8::Zero();
    strength_[group] = Splat(0);
  }
  double theirs = 0;
  for (size_t i = 0; i < count; ++i) {
    const Sum& sum = sums_[places[i].second];
    const size_t group = i / kLanes;
    const int lane = static_cast<int>(i % kLanes);
    center_[group].Set(lane, sum.positions / sum.count);
    normal_[group].Set(lane, sum.normals.normalized());
    strength_[group][lane] = places[i].first * Square(kSpotCube_m);
    theirs += places[i].first;
  }
  const auto others = static_cast<double>(sums_.size() - count);
  rest_ = others > 0 ? static_cast<float>((all - theirs) / others) : 0.0f;
  known_ = count > 0 && theirs >= kLeastLight * all;
}

void SpotView::Look(const BrightSpots& spots, const Vec3f& position, const Vec3f& normal) {
  share_ = 0;
  if (!spots.known_) return;
  constexpr float kRadius = BrightSpots::kRadius_m, kRadius2 = kRadius * kRadius;
  const Vec3x8 here = Vec3x8(position), facing = Vec3x8(normal);
  Float8 inverses[kGroups];
  Float8 sum = Splat(0);
  for (int group = 0; group < kGroups; ++group) {
    const Vec3x8 to = spots.center_[group] - here;
    const Float8 d2 = Dot(to, to);
    const Float8 inverse = 1.0f / Sqrt(Max(d2, kRadius2));
    inverses[group] = inverse;
    axis_[group] = to * inverse;
    const Float8 rim = kRadius * inverse;  // Sine of a cone's half angle.
    const Float8 seen_here = Dot(axis_[group], facing) + rim;
    const Float8 seen_there = rim - Dot(axis_[group], spots.normal_[group]);
    const Float8 importance =
        spots.strength_[group] * Max(seen_here, 0.0f) * Max(seen_there, 0.0f) * Square(inverse);
    // Nearby spots are left out: any direction may meet them.
    importance_[group] = d2 > 2.0f * kRadius2 ? importance : Splat(0);
    sum += importance_[group];
  }
  total_ = Sum(sum);
  if (!(total_ > 0.0f)) return;
  const float part = total_ / (total_ + kPi * spots.rest_);
  if (part < kLeastShare) return;
  share_ = std::min(part, kMostShare);
  for (int group = 0; group < kGroups; ++group) {
    cos_rim_[group] = Sqrt(Max(1.0f - Square(kRadius * inverses[group]), 0.5f));
    density_[group] = importance_[group] / ((2.0f * kPi * total_) * (1.0f - cos_rim_[group]));
  }
}

Vec3f SpotView::Sample(float choice, const Vec2f& u) const {
  float left = choice * total_;
  int last = 0;
  for (int i = 0; i < BrightSpots::kMost; ++i) {
    const float importance = importance_[i / kLanes][i % kLanes];
    if (importance <= 0.0f) continue;
    last = i;
    if (left < importance) break;
    left -= importance;
  }
  const int group = last / kLanes, lane = last % kLanes;
  const float cosine = 1.0f - u.x() * (1.0f - cos_rim_[group][lane]);
  return ShadingFrame(axis_[group].Get(lane)).ToWorld(DirectionAt(cosine, 2.0f * kPi * u.y()));
}

float SpotView::Pdf(const Vec3f& direction) const {
  const Vec3x8 all = Vec3x8(direction);
  Float8 sum = Splat(0);
  for (int group = 0; group < kGroups; ++group) {
    // Directions on the rim may be outside by rounding.
    const Mask8 inside = Dot(axis_[group], all) >= cos_rim_[group] - 3e-7f;
    sum += inside ? density_[group] : Splat(0);
  }
  return Sum(sum);
}

}  // namespace parallax
