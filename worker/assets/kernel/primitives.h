// Solids: rounded boxes, turned bodies, sheets, balls. All are closed, face outwards, and have
// texture coordinates along their longest side unless said otherwise.
#pragma once

#include <functional>

#include "worker/assets/kernel/curves.h"
#include "worker/assets/kernel/shape.h"

namespace parallax::kernel {

// Edges and divisions of a rounded box.
struct BoxOptions {
  float bevel_m = 0.003f;  // Radius of the edges; 0 = sharp. At most half of the shortest side.
  int bevel_steps = 1;     // 1: two facets an edge (108 triangles); 2: four.
  // Divisions of the flat parts along x, y, z, for shapes that are bent later.
  Eigen::Array3i pieces{1, 1, 1};
};

// A box centred on the origin.
Shape RoundedBox(const Vec3f& size, const BoxOptions& options = {});

// A box between two corners, in any order: the board of furniture making.
Shape Board(const Vec3f& a, const Vec3f& b, float bevel_m = 0.002f);

// Segments, modulation and print of a turned body.
struct LatheOptions {
  int segments = 0;  // 0: chosen by the largest radius.
  // Radius factor at an angle and a height, for flutes and squarish bodies.
  std::function<float(float theta_rad, float z)> modulate;
  // Faces whose outer side lies within [print_from_z, print_to_z] get `print_group` and uv running
  // round and up.
  float print_from_z = 0, print_to_z = 0;
  int print_repeats = 1;  // Copies of the print round the body.
  uint8_t print_group = 1;
  uint8_t group = 0;
};

// Turns a profile of (radius, z) about the z axis. The profile goes up along the outside, from the
// middle of the underside to the middle of the top or, for a vessel, further down its inside. Ends
// off the axis are closed flat.
Shape Lathe(const Path2& profile, const LatheOptions& options = {});

// A ring: the closed section (x = distance from the axis, y = z), counter-clockwise, turned about
// the z axis.
Shape LatheRing(const Path2& section, int segments = 0);

// An outer profile (from the middle of the foot up to the rim) made into a vessel: rounded rim,
// inside wall `thickness` inwards, floor at least `floor_m` above the foot.
Path2 VesselProfile(const Path2& outer, float thickness, float floor_m);

// Solids along +z from the origin; edges are rounded by `bevel_m`.
Shape Cylinder(float radius, float height, float bevel_m = 0.001f, int segments = 0);
Shape Cone(float bottom_radius, float top_radius, float height, float bevel_m = 0.001f,
           int segments = 0);
Shape Ball(float radius, int segments = 0);
Shape Ellipsoid(const Vec3f& radii, int segments = 0);

// Grid and thickness of a sheet.
struct SheetOptions {
  int pieces_u = 16, pieces_v = 16;
  float thickness_m = 0.002f;  // Grown downwards from the surface, against its normal.
  Vec2f size_m{1, 1};          // Texture extent of u and v in [0, 1].
  bool round_rim = true;       // A soft edge; false: a cut one.
  uint8_t top_group = 0, bottom_group = 0;
  bool print_uv = false;  // uv = (u, v) on the top faces.
};

// A sheet with thickness over `surface(u, v)`; the normal is du x dv.
Shape Sheet(const std::function<Vec3f(float u, float v)>& surface,
            const SheetOptions& options = {});

}  // namespace parallax::kernel
