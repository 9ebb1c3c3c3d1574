// The real effect of each light on each part of a room, over what its power and distance promise:
// learnt from the shadow rays of the paths that fill the radiance cache, so that no picture spends
// its samples on lamps behind cupboards or above their shades.
//
// The room is cut into cubes, each with six facings; together they are cells. A gain is the root
// mean square of the arriving light over the light's importance, so that lights whose contribution
// varies most get most samples. Every light keeps some chance everywhere: estimates stay unbiased.
//
// Not thread-safe while trials are added; queries are.
#pragma once

#include <cstdint>
#include <vector>

#include "common/math/lanes.h"

namespace parallax {

// Gains of all lights in all cells of one room.
class LightGains {
 public:
  static constexpr float kLeast = 0.05f;  // The least gain: no light is ruled out for good.

  LightGains() = default;
  LightGains(const Box3f& box, size_t lights);

  // Cells of eight points with these unit normals.
  Int8 CellOf(const Vec3x8& position, const Vec3x8& normal) const;
  // Gains of a light in cells; 1 until Learn.
  Float8 Of(Int8 cells, size_t light) const {
    if (gains_.empty()) return Splat(1);
    return Gather(gains_.data() + light, cells * static_cast<int32_t>(lights_));
  }
  float Of(int32_t cell, int32_t light) const {
    return gains_.empty() ? 1.0f : gains_[Place(cell, light)];
  }

  // Adds a trial. `gain`: irradiance found by one sample of the light, over the light's importance.
  void Add(int32_t cell, int32_t light, float gain);
  // Computes the gains from all trials added so far.
  void Learn();

 private:
  struct Sum {
    float squares = 0, trials = 0;
  };

  size_t Place(int32_t cell, int32_t light) const {
    return static_cast<size_t>(cell) * lights_ + static_cast<size_t>(light);
  }

  Box3f box_;
  Eigen::Array3i size_ = Eigen::Array3i::Zero();  // In cubes.
  size_t lights_ = 0;
  std::vector<Sum> sums_;     // Indexed by cell, then light.
  std::vector<float> gains_;  // Likewise.
};

}  // namespace parallax
