#include "worker/assets/kernel/curves.h"

#include <algorithm>
#include <cmath>

#include "worker/assets/kernel/detail_scope.h"

namespace parallax::kernel {
namespace {

template <typename V>
std::vector<V> SplineOf(const std::vector<V>& p, int steps, bool closed) {
  const int n = static_cast<int>(p.size());
  if (n < 3 || steps < 2) return p;
  const auto at = [&](int i) -> V {
    if (closed) return p[static_cast<size_t>((i % n + n) % n)];
    if (i < 0) return 2 * p[0] - p[1];
    if (i >= n) return 2 * p[n - 1] - p[n - 2];
    return p[static_cast<size_t>(i)];
  };
  std::vector<V> out;
  const int pieces = closed ? n : n - 1;
  for (int i = 0; i < pieces; ++i) {
    const V a = at(i - 1), b = at(i), c = at(i + 1), d = at(i + 2);
    for (int s = 0; s < steps; ++s) {
      const float t = static_cast<float>(s) / static_cast<float>(steps);
      const float t2 = t * t, t3 = t2 * t;
      out.push_back(0.5f * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t2 +
                            (3 * b - a - 3 * c + d) * t3));
    }
  }
  if (!closed) out.push_back(p.back());
  return out;
}

template <typename V>
std::vector<V> FilletedOf(const std::vector<V>& p, float radius, int steps) {
  if (p.size() < 3 || radius <= 0) return p;
  std::vector<V> out{p.front()};
  for (size_t i = 1; i + 1 < p.size(); ++i) {
    const V in = (p[i] - p[i - 1]).normalized(), go = (p[i + 1] - p[i]).normalized();
    const float turn = std::acos(std::clamp(in.dot(go), -1.0f, 1.0f));
    if (turn < 1e-3f) {
      out.push_back(p[i]);
      continue;
    }
    const float room = 0.49f * std::min((p[i] - p[i - 1]).norm(), (p[i + 1] - p[i]).norm());
    const float cut = std::min(radius * std::tan(0.5f * turn), room);
    const float r = cut / std::tan(0.5f * turn);
    const V a = p[i] - cut * in;
    const V side = (go - in.dot(go) * in).normalized();
    for (int s = 0; s <= steps; ++s) {
      const float angle = turn * static_cast<float>(s) / static_cast<float>(steps);
      out.push_back(a + r * std::sin(angle) * in + r * (1 - std::cos(angle)) * side);
    }
  }
  out.push_back(p.back());
  return out;
}

}  // namespace

Path3 Spline(const Path3& points, int steps, bool closed) {
  return SplineOf(points, steps, closed);
}
Path2 Spline(const Path2& points, int steps, bool closed) {
  return SplineOf(points, steps, closed);
}

Path2 Arc(const Vec2f& center, float radius_x, float radius_y, float from_rad, float to_rad,
          int steps) {
  Path2 out;
  for (int i = 0; i <= steps; ++i) {
    const float a = Lerp(from_rad, to_rad, static_cast<float>(i) / static_cast<float>(steps));
    out.push_back(center + Vec2f(radius_x * std::cos(a), radius_y * std::sin(a)));
  }
  return out;
}

Path2 Filleted(const Path2& points, float radius, int steps) {
  return FilletedOf(points, radius, steps);
}
Path3 Filleted(const Path3& points, float radius, int steps) {
  return FilletedOf(points, radius, steps);
}

Path3 Resampled(const Path3& points, float step) {
  Path3 out{points.front()};
  for (size_t i = 1; i < points.size(); ++i) {
    const float length = (points[i] - points[i - 1]).norm();
    const int pieces = std::max(1, static_cast<int>(std::ceil(length / step)));
    for (int k = 1; k <= pieces; ++k) {
      const float t = static_cast<float>(k) / static_cast<float>(pieces);
      out.push_back(points[i - 1] + t * (points[i] - points[i - 1]));
    }
  }
  return out;
}

Path2 RectSection(float width, float height, float corner_radius, int corner_steps) {
  const float w = 0.5f * width, h = 0.5f * height;
  const float r = std::min(corner_radius, 0.98f * std::min(w, h));
  if (r <= 0) return {{-w, -h}, {w, -h}, {w, h}, {-w, h}};
  Path2 out;
  const Vec2f centers[4] = {{w - r, h - r}, {r - w, h - r}, {r - w, r - h}, {w - r, r - h}};
  for (int q = 0; q < 4; ++q) {
    const float from = 0.25f * kTau * static_cast<float>(q);
    const Path2 corner = Arc(centers[q], r, r, from, from + 0.25f * kTau, corner_steps);
    out.insert(out.end(), corner.begin(), corner.end());
  }
  return out;
}

Path2 EllipseSection(float width, float height, int segments) {
  Path2 out = Arc(Vec2f::Zero(), 0.5f * width, 0.5f * height, 0, kTau, segments);
  out.pop_back();
  return out;
}

Path2 SuperellipseSection(float width, float height, float exponent, int segments) {
  Path2 out = EllipseSection(2, 2, segments);
  const float power = 2.0f / exponent;
  for (Vec2f& p : out) {
    p = {0.5f * width * std::copysign(std::pow(std::abs(p.x()), power), p.x()),
         0.5f * height * std::copysign(std::pow(std::abs(p.y()), power), p.y())};
  }
  return out;
}

std::function<float(float)> SmoothThrough(std::vector<std::pair<float, float>> knots) {
  return [knots = std::move(knots)](float x) {
    if (x <= knots.front().first) return knots.front().second;
    if (x >= knots.back().first) return knots.back().second;
    size_t i = 1;
    while (knots[i].first < x) ++i;
    const auto slope = [&](size_t k) {
      if (k == 0 || k + 1 == knots.size()) return 0.0f;
      const float left = knots[k].second - knots[k - 1].second;
      const float right = knots[k + 1].second - knots[k].second;
      if (left * right <= 0) return 0.0f;  // No overshoot at a turning point.
      return (left + right) / (knots[k + 1].first - knots[k - 1].first);
    };
    const float width = knots[i].first - knots[i - 1].first;
    const float t = (x - knots[i - 1].first) / width;
    const float t2 = t * t, t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * knots[i - 1].second + (t3 - 2 * t2 + t) * width * slope(i - 1) +
           (3 * t2 - 2 * t3) * knots[i].second + (t3 - t2) * width * slope(i);
  };
}

int CircleSegments(float radius, float tolerance_m) {
  const float ratio = std::clamp(1.0f - tolerance_m / std::max(radius, 1e-4f), -1.0f, 1.0f);
  const int segments = static_cast<int>(std::ceil(kTau / (2 * std::max(std::acos(ratio), 0.01f))));
  return DetailedSegments(std::clamp((segments + 3) / 4 * 4, 12, 72), radius);
}

}  // namespace parallax::kernel
