#include "worker/assets/household/vessel_parts.h"

#include <algorithm>
#include <cmath>

namespace parallax {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

Path2 Profile(const std::vector<std::pair<float, float>>& shares, float radius, float height,
              int steps) {
  Path2 p;
  for (const auto& [r, z] : shares) p.emplace_back(r * radius, z * height);
  return Spline(p, steps);
}

Path2 WithFoot(const Path2& wall) {
  Path2 out{{0, 0}, {wall.front().x() * 0.9f, 0}};
  out.insert(out.end(), wall.begin(), wall.end());
  return out;
}

Shape LoopHandle(const LoopHandleParams& p) {
  const float x_low = p.low_x, z_low = p.low_z, x_high = p.high_x, z_high = p.high_z;
  const float out = p.out_m, width = p.width_m, thick = p.thickness_m;
  const float dz = z_high - z_low;
  const Path3 path = Spline(Path3{{x_high - 0.004f, 0, z_high},
                                  {x_high + 0.55f * out, 0, z_high + 0.06f * dz},
                                  {x_high + out, 0, z_high - 0.22f * dz},
                                  {x_low + 0.95f * out, 0, z_low + 0.32f * dz},
                                  {x_low + 0.45f * out, 0, z_low + 0.03f * dz},
                                  {x_low - 0.004f, 0, z_low}},
                            6);
  SweepOptions options;
  options.up = Vec3f::UnitY();
  options.keep_up = true;
  options.scale = [](float t) { return Vec2f::Constant(1.15f - 0.35f * std::sin(kPi * t)).eval(); };
  return Sweep(path, EllipseSection(thick, width, 14), options);
}

int LabelCopies(float radius_m, float height_m) {
  return std::clamp(static_cast<int>(std::lround(2 * kPi * radius_m / height_m)), 1, 3);
}

float RadiusAt(const Path2& wall, float z) {
  for (size_t i = 1; i < wall.size(); ++i) {
    if (wall[i].y() >= z) {
      const float t = (z - wall[i - 1].y()) / std::max(1e-6f, wall[i].y() - wall[i - 1].y());
      return Lerp(wall[i - 1].x(), wall[i].x(), std::clamp(t, 0.0f, 1.0f));
    }
  }
  return wall.back().x();
}

}  // namespace parallax
