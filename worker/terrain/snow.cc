#include "worker/terrain/snow.h"

#include <algorithm>
#include <cmath>

#include "worker/materials/kernel/noise.h"

namespace parallax {
namespace {

constexpr int kPasses = 14;
constexpr float kMost = 5;  // Deepest, in units of depth_m: gullies are not filled to the brim.

// Snow that fell and was blown, before it settles.
Field Fallen(const Field& ground, const SnowSpec& spec) {
  Field snow = ground;
  const int n = ground.size;
  const Field broad = BoxBlurred(ground, 4);
  const Vec2f wind(std::cos(spec.wind_rad), std::sin(spec.wind_rad));
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) {
      const auto at = [&](const Field& field, int x, int y) {
        return field.At(std::clamp(x, 0, n - 1), std::clamp(y, 0, n - 1));
      };
      const auto slope_of = [&](const Field& field) -> Vec2f {
        return Vec2f((at(field, column + 1, row) - at(field, column - 1, row)),
                     (at(field, column, row + 1) - at(field, column, row - 1))) /
               (2 * field.cell_m);
      };
      const float height = ground.At(column, row);
      const float holds =
          1 - noise::SmoothStep(spec.slope, 2 * spec.slope, slope_of(ground).norm());
      const float above = noise::SmoothStep(spec.line_m - spec.line_soft_m, spec.line_m, height);
      // The lee falls with the wind; hollows lie below their surroundings.
      const float lee = -wind.dot(slope_of(broad));
      const float hollow = (broad.At(column, row) - height) / ground.cell_m;
      const Vec2f q = ground.PositionOf(column, row) / 23.0f;
      const float drift = noise::Gradient3(q.x(), q.y(), 0.31f * q.x() - 0.23f * q.y(), spec.seed);
      const float blown = std::clamp(1 + 1.1f * lee + 0.8f * hollow + 0.5f * drift, 0.15f, 2.5f);
      snow.At(column, row) = spec.depth_m * holds * above * blown;
    }
  }
  return snow;
}

}  // namespace

Field SnowOn(const Field& ground, const SnowSpec& spec) {
  Field snow = Fallen(ground, spec);
  const int n = ground.size;
  Field settled = snow;
  for (int pass = 0; pass < kPasses; ++pass) {
    for (int row = 1; row + 1 < n; ++row) {
      for (int column = 1; column + 1 < n; ++column) {
        const auto surface = [&](int x, int y) { return ground.At(x, y) + snow.At(x, y); };
        const float depth = snow.At(column, row), here = surface(column, row);
        const float around = 0.25f * (surface(column - 1, row) + surface(column + 1, row) +
                                      surface(column, row - 1) + surface(column, row + 1));
        // Smooths deep snow only.
        const float soft = std::min(1.0f, depth / (0.5f * spec.depth_m));
        settled.At(column, row) =
            std::clamp(depth + 0.6f * soft * (around - here), 0.0f, kMost * spec.depth_m);
      }
    }
    snow.values.swap(settled.values);
  }
  return snow;
}

}  // namespace parallax
