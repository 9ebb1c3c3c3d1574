// Organic bodies: cages of few faces, smoothed by OpenSubdiv (Catmull-Clark). Cages describe shapes
// for which grids of functions are awkward: a tub with one sloped end, a fork whose tines grow out
// of its shoulder, a shirt whose sleeves join its trunk.
#pragma once

#include <functional>
#include <vector>

#include "worker/assets/kernel/curves.h"
#include "worker/assets/kernel/shape.h"

namespace parallax::kernel {

// An edge that stays sharp for `sharpness` levels: 0 smooth, 1 soft, 2 narrow, 10 a knife's edge.
struct Crease {
  uint32_t a = 0, b = 0;
  float sharpness = 10;
};

// Closed, faces outwards, as a finished shape. Smoothing contracts round parts, as a spline does
// its control points; creased edges stay in place.
struct Cage {
  Shape shape;
  std::vector<Crease> creases;
};

// The surface after `levels` >= 1 subdivisions of the cage, with points on the limit surface; four
// times the faces a level. Texture is interpolated smoothly, uv within its borders, groups by face.
// The level of detail changes the number of levels.
Shape Subdivided(const Cage& cage, int levels);

// A cross-section. `sharpness` creases the whole ring; `corners` creases the edges from its
// diagonal points to the next ring.
struct CageRing {
  Path3 points;
  float sharpness = 0;
  float corners = 0;
};

// Eight points around the z axis, counter-clockwise from (high x, middle): the sides' middles and
// the diagonals. The limit curve fills the box (beyond exponent 4 it exceeds it by less than a
// hundredth) and equals the superellipse of this exponent at its diagonals (2 an ellipse, larger
// squarer, at most 12). 0: the rectangle itself, to be creased.
Path3 EightPoints(const Vec2f& low, const Vec2f& high, float z, float exponent);

// A body through rings with one even number of points, counter-clockwise seen against their
// direction of travel; the ends are closed.
Cage Loft(const std::vector<CageRing>& rings);

// The grid of a slab.
struct SlabOptions {
  int columns = 1, rows = 1;                            // Cells.
  std::function<bool(int column, int row)> keep;        // Whether a cell is there; null: all.
  std::function<Vec3f(int column, int row)> point;      // Upper side, (columns + 1) x (rows + 1).
  std::function<float(int column, int row)> thickness;  // Downwards along z, > 0.
  float rim_sharpness = 1;
};

// A sheet of cells with thickness, for flat bodies of any outline. Texture equals the points.
Cage Slab(const SlabOptions& options);

// Extrudes a face outwards as a new end of the body, moved by `by` and scaled about its middle;
// returns `face`, which remains the end.
uint32_t ExtrudeFace(Shape& shape, uint32_t face, const Vec3f& by, float scale = 1);

// The face whose middle is nearest to the point.
uint32_t NearestFace(const Shape& shape, const Vec3f& to);

}  // namespace parallax::kernel
