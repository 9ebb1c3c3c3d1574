// Curves, profiles and cross-sections: plain lists of points that primitives.h and sweep.h turn
// into solids.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "common/math/types.h"

namespace parallax::kernel {

using Path2 = std::vector<Vec2f>;
using Path3 = std::vector<Vec3f>;

// A smooth curve through all points (Catmull-Rom) with `steps` pieces between neighbours. Closed:
// returns to the first point, which is not repeated.
Path3 Spline(const Path3& points, int steps, bool closed = false);
Path2 Spline(const Path2& points, int steps, bool closed = false);

// A part of an ellipse as `steps` + 1 points from `from_rad` to `to_rad`.
Path2 Arc(const Vec2f& center, float radius_x, float radius_y, float from_rad, float to_rad,
          int steps);

// The polyline with inner corners rounded to `radius` (less where a leg is short), `steps` pieces a
// corner.
Path2 Filleted(const Path2& points, float radius, int steps);
Path3 Filleted(const Path3& points, float radius, int steps);

// Adds points so that neighbours are at most `step` apart; the given points stay.
Path3 Resampled(const Path3& points, float step);

// Closed sections, counter-clockwise, centred on the origin.
Path2 RectSection(float width, float height, float corner_radius, int corner_steps = 2);
Path2 EllipseSection(float width, float height, int segments);
// |x/a|^e + |y/b|^e = 1; e = 2 an ellipse, larger squarer.
Path2 SuperellipseSection(float width, float height, float exponent, int segments);

// A smooth function through (x, y) knots with increasing x; constant beyond the ends.
std::function<float(float)> SmoothThrough(std::vector<std::pair<float, float>> knots);

// Number of segments so that a circle of this radius deviates by at most `tolerance_m`, a multiple
// of 4 in [12, 72].
int CircleSegments(float radius, float tolerance_m = 0.0004f);

// Linear and smooth interpolation.
inline float Lerp(float a, float b, float t) { return a + (b - a) * t; }
inline float Smooth01(float t) {
  t = t < 0 ? 0 : (t > 1 ? 1 : t);
  return t * t * (3 - 2 * t);
}

}  // namespace parallax::kernel
