#include "worker/scene/types/nature/rules/plot.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace parallax {
namespace {

constexpr double kMostOfPlot_m = 1000;  // Bound of a plot's coordinates.

// Weight of the land itself: 0 on the plot, 1 from its blend on, with zero slopes at both.
float ShareOfLand(const v1::Plot& plot, const Vec2f& p) {
  const float t = std::clamp(FromPlot(plot, p) / static_cast<float>(plot.blend_m()), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

}  // namespace

float FromPlot(const v1::Plot& plot, const Vec2f& p) {
  const Vec2f low(static_cast<float>(plot.low_x_m()), static_cast<float>(plot.low_y_m()));
  const Vec2f high(static_cast<float>(plot.high_x_m()), static_cast<float>(plot.high_y_m()));
  return (low - p).cwiseMax(p - high).cwiseMax(0.0f).norm();
}

MeshedSurface GroundWithPlot(const v1::Plot& plot, const Terrain& terrain) {
  MeshedSurface ground = GroundOf(terrain);
  const auto level = static_cast<float>(plot.level_m()), base = static_cast<float>(plot.base_m());
  ground.height = [plot, level, base, land = ground.height](const Vec2f& p, float footprint_m) {
    const float share = ShareOfLand(plot, p);
    return share > 0 ? level + share * (land(p, footprint_m) - base) : level;
  };
  ground.slope = [plot, height = ground.height, land = ground.slope](const Vec2f& p,
                                                                     float footprint_m) -> Vec2f {
    if (ShareOfLand(plot, p) >= 1) return land(p, footprint_m);
    const float e = std::max(footprint_m, 0.1f);
    const Vec2f x(e, 0), y(0, e);
    return Vec2f(height(p + x, footprint_m) - height(p - x, footprint_m),
                 height(p + y, footprint_m) - height(p - y, footprint_m)) /
           (2 * e);
  };
  ground.steepness = [plot, land = ground.steepness](const Vec2f& p) {
    return ShareOfLand(plot, p) * land(p);
  };
  if (ground.ledge) {
    ground.ledge = [plot, base, level, land = ground.ledge](const Vec2f& p, float height_m) {
      return ShareOfLand(plot, p) < 1 ? 0 : land(p, height_m - level + base);
    };
  }
  return ground;
}

absl::Status CheckPlot(const v1::Plot& plot) {
  const struct {
    const char* name;
    double value, low, high;
  } numbers[] = {
      {"low_x_m", plot.low_x_m(), -kMostOfPlot_m, kMostOfPlot_m},
      {"low_y_m", plot.low_y_m(), -kMostOfPlot_m, kMostOfPlot_m},
      {"high_x_m", plot.high_x_m(), plot.low_x_m(), kMostOfPlot_m},
      {"high_y_m", plot.high_y_m(), plot.low_y_m(), kMostOfPlot_m},
      {"level_m", plot.level_m(), -kMostOfPlot_m, kMostOfPlot_m},
      {"base_m", plot.base_m(), -10 * kMostOfPlot_m, 10 * kMostOfPlot_m},
      {"blend_m", plot.blend_m(), 0.5, kMostOfPlot_m},
      {"clearing_m", plot.clearing_m(), 0, kMostOfPlot_m},
  };
  for (const auto& number : numbers) {
    if (number.value >= number.low && number.value <= number.high) continue;
    return InvalidArgument("terrain: plot.{} is {:f}, allowed is {:f} to {:f}", number.name,
                           number.value, number.low, number.high);
  }
  return absl::OkStatus();
}

}  // namespace parallax
