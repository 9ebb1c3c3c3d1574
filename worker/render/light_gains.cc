#include "worker/render/light_gains.h"

#include <algorithm>
#include <cmath>

#include "worker/render/sampling.h"

namespace parallax {
namespace {

constexpr float kCube_m = 0.6f;
constexpr int kMostCubes = 64;    // Along an axis.
constexpr float kPrior = 16;      // Trials that what the whole room says counts for in a cell.
constexpr float kLongest = 4.0f;  // Gains are cut here: a light's surface at hand is no rule.

}  // namespace

LightGains::LightGains(const Box3f& box, size_t lights) : box_(box), lights_(lights) {
  size_ = (box.sizes() / kCube_m).array().ceil().cast<int>().max(1).min(kMostCubes);
  sums_.resize(static_cast<size_t>(size_.prod()) * 6 * lights);
}

uint32_t LightGains::CellOf(const Vec3f& position, const Vec3f& normal) const {
  const Eigen::Array3i cube =
      ((position - box_.min()).array() / box_.sizes().array() * size_.cast<float>())
          .cast<int>()
          .max(0)
          .min(size_ - 1);
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  const int face = 2 * axis + (normal[axis] < 0.0f ? 1 : 0);
  return static_cast<uint32_t>(((cube.z() * size_.y() + cube.y()) * size_.x() + cube.x()) * 6 +
                               face);
}

void LightGains::Add(uint32_t cell, uint32_t light, float gain) {
  Sum& sum = sums_[cell * lights_ + light];
  sum.squares += Square(std::min(gain, kLongest));
  ++sum.trials;
}

void LightGains::Learn() {
  std::vector<Sum> whole(lights_);
  for (size_t i = 0; i < sums_.size(); ++i) {
    whole[i % lights_].squares += sums_[i].squares;
    whole[i % lights_].trials += sums_[i].trials;
  }
  gains_.resize(sums_.size());
  for (size_t i = 0; i < sums_.size(); ++i) {
    const Sum& all = whole[i % lights_];
    const float usual = all.trials > 0 ? all.squares / all.trials : 1.0f;
    gains_[i] = std::max(
        kLeast, std::sqrt((sums_[i].squares + kPrior * usual) / (sums_[i].trials + kPrior)));
  }
}

}  // namespace parallax
