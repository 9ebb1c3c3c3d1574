// Organic bodies: a cage of few faces, made smooth by OpenSubdiv (Catmull-Clark). What a grid of
// functions can't say shortly, a cage can: a tub with one sloped end, a fork whose tines grow out
// of its shoulder, a shirt whose sleeves join its trunk.
#pragma once

#include <functional>
#include <vector>

#include "worker/assets/kernel/curves.h"
#include "worker/assets/kernel/shape.h"

namespace parallax::kernel {

// An edge that stays sharp for so many levels: 0 smooth, 1 a soft edge, 2 a narrow one, 10 a
// knife's.
struct Crease {
  uint32_t a = 0, b = 0;
  float sharpness = 10;
};

// Closed, faces outwards, as a finished shape. Smoothing draws round parts in, as a spline does its
// control points; creased edges stay where they are.
struct Cage {
  Shape shape;
  std::vector<Crease> creases;
};

// The surface that `levels` >= 1 subdivisions of the cage lead to, its points on the limit surface;
// four times the faces a level. Texture is carried along smoothly, uv within its borders, groups by
// face. The level of detail changes the number of levels.
Shape Subdivided(const Cage& cage, int levels);

// A ring's `sharpness` creases it all round; `corners` the edges from its diagonal points to the
// next ring.
struct CageRing {
  Path3 points;
  float sharpness = 0;
  float corners = 0;
};

// Eight points round the z axis, counter-clockwise from (high x, middle): the sides' middles and
// the diagonals. The smooth curve that they lead to fills the box (beyond exponent 4 it swells by
// less than a hundredth) and is the superellipse of this exponent at its diagonals (2 an ellipse,
// larger squarer, at most 12); 0: the rectangle itself, to be creased.
Path3 EightPoints(const Vec2f& low, const Vec2f& high, float z, float exponent);

// A body through rings of one even number of points, counter-clockwise seen against the way that
// they follow each other; the ends are closed.
Cage Loft(const std::vector<CageRing>& rings);

struct SlabOptions {
  int columns = 1, rows = 1;                            // Cells.
  std::function<bool(int column, int row)> keep;        // Whether a cell is there; null: all.
  std::function<Vec3f(int column, int row)> point;      // Upper side, (columns + 1) x (rows + 1).
  std::function<float(int column, int row)> thickness;  // Downwards along z, > 0.
  float rim_sharpness = 1;
};

// A sheet of cells with thickness: flat bodies of any outline. Texture: the points'.
Cage Slab(const SlabOptions& options);

// Pushes a face outwards as a new end of the body, moved by `by` and scaled about its middle;
// returns `face`, which stays the end.
uint32_t ExtrudeFace(Shape& shape, uint32_t face, const Vec3f& by, float scale = 1);

// The face whose middle is nearest to the point.
uint32_t NearestFace(const Shape& shape, const Vec3f& to);

}  // namespace parallax::kernel
