#include "worker/render/lights/light_gains.h"

#include <algorithm>
#include <cmath>

#include "worker/render/surface/sampling.h"

namespace parallax {
namespace {

constexpr float kGainCube_m = 0.6f;
constexpr int kMostCubes = 64;    // Along an axis.
constexpr float kPrior = 16;      // Weight of the room's mean in a cell, in trials.
constexpr float kLongest = 4.0f;  // Gains are clamped here: surfaces right at a light mislead.

}  // namespace

LightGains::LightGains(const Box3f& box, size_t lights) : box_(box), lights_(lights) {
  size_ = (box.sizes() / kGainCube_m).array().ceil().cast<int>().max(1).min(kMostCubes);
  sums_.resize(static_cast<size_t>(size_.prod()) * 6 * lights);
}

Int8 LightGains::CellOf(const Vec3x8& position, const Vec3x8& normal) const {
  const auto cube = [&](Float8 p, int axis) {
    const float cubes = static_cast<float>(size_[axis]);
    const Float8 at = (p - box_.min()[axis]) * (cubes / box_.sizes()[axis]);
    return __builtin_convertvector(Clamp(at, 0.0f, cubes - 1.0f), Int8);
  };
  const Float8 x = Abs(normal.x), y = Abs(normal.y), z = Abs(normal.z);
  const Mask8 along_x = (x >= y) & (x >= z), along_y = y >= z;
  const Float8 height = along_x ? normal.x : along_y ? normal.y : normal.z;
  const Int8 axis = along_x ? Int8{} : along_y ? Int8{} + 1 : Int8{} + 2;
  const Int8 face = 2 * axis - (height < 0.0f);
  return ((cube(position.z, 2) * size_.y() + cube(position.y, 1)) * size_.x() +
          cube(position.x, 0)) *
             6 +
         face;
}

void LightGains::Add(int32_t cell, int32_t light, float gain) {
  Sum& sum = sums_[Place(cell, light)];
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
