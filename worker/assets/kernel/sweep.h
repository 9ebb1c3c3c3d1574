// A cross-section carried along a curve (legs, rails, tubes, arms, piping) and straight extrusions.
#pragma once

#include <functional>

#include "worker/assets/kernel/curves.h"
#include "worker/assets/kernel/shape.h"

namespace parallax::kernel {

// Variation of the section along the path, ends and frame.
struct SweepOptions {
  // Factors on the section's x and y at t in [0, 1] of the length; null: 1.
  std::function<Vec2f(float t)> scale;
  std::function<float(float t)> twist_rad;
  bool closed = false;    // A ring: the last point joins the first, which is not repeated.
  float end_round_m = 0;  // Radius of the rounded ends; half of the section's size makes a capsule.
  // The section's y axis leans towards `up` as far as the path allows; zero: +z, or +y for a path
  // that starts upright.
  Vec3f up = Vec3f::Zero();
  // Applies `up` at every point, instead of transporting the first frame without twist.
  bool keep_up = false;
};

// The section is counter-clockwise, its x axis = up x path direction. Texture x runs along the
// path. Requires a path with at least two different points.
Shape Sweep(const Path3& path, const Path2& section, const SweepOptions& options = {});

// A round bar along a polyline or curve, ends rounded by `end_round_m`.
Shape Tube(const Path3& path, float radius, float end_round_m = 0.0f, int segments = 0);
Shape Ring(const Path3& closed_path, float radius, int segments = 8);

// A straight tapered round bar with rounded ends: turned legs and rungs without profile.
Shape Rod(const Vec3f& from, const Vec3f& to, float from_radius, float to_radius,
          float end_round_m = 0.001f);
// A straight tapered square bar; the section stays parallel to the world's axes where the bar is
// upright.
Shape Bar(const Vec3f& from, const Vec3f& to, const Vec2f& from_size, const Vec2f& to_size,
          float bevel_m = 0.002f, const Vec3f& up = Vec3f::Zero());

// A prism from z = 0 to `height` over a simple polygon, counter-clockwise; long edges are rounded
// by `bevel_m`. `pieces`: divisions along the height, for prisms that are bent later.
Shape Extrude(const Path2& polygon, float height, float bevel_m = 0.0f, int pieces = 1);

// Triangles (indices into `polygon`) of a simple polygon, counter-clockwise.   Source: Meisters'
// ear clipping.
std::vector<std::array<uint32_t, 3>> Triangulate(const Path2& polygon);

}  // namespace parallax::kernel
