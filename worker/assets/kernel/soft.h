// Soft objects: cushions, pillows, draped cloth. Closed solids, texture in metres of cloth.
#pragma once

#include "worker/assets/kernel/primitives.h"
#include "worker/assets/kernel/shape.h"
#include "worker/assets/kernel/shape_noise.h"

namespace parallax::kernel {

// Shape, wrinkles and seams of a boxed cushion.
struct CushionOptions {
  float edge_radius_m = 0.03f;
  float bulge_top_m = 0.025f;  // How far the middle of the top rises.
  float bulge_bottom_m = 0.0f;
  float bulge_side_m = 0.008f;
  float wrinkle_m = 0.003f;  // Depth of wrinkles near seams.
  float wrinkle_size_m = 0.12f;
  float target_edge_m = 0.03f;  // Finer shows wrinkles better and costs triangles (quadratically).
  float piping_m = 0.0f;        // Radius of the cord along the upper and lower seams; 0 = none.
  uint8_t piping_group = 0;
  int tufts_x = 0, tufts_y = 0;  // Buttons pulled into the top.
  float tuft_depth_m = 0.02f;
};

// A boxed seat cushion, centred on the origin: `size` is that of the unbulged box.
Shape Cushion(const Vec3f& size, const CushionOptions& options, const Noise& noise);

// Shape and wrinkles of a stuffed bag.
struct PillowOptions {
  float wrinkle_m = 0.004f;
  float corner_pull = 0.06f;  // Draw-in of the sides' middles against the corners.
  float sharpness = 0.5f;  // Exponent of the profile at the seam: 0.5 round, larger flatter edges.
  int pieces = 28;
};

// A stuffed bag with its seam in the plane z = 0, centred on the origin; thickness is its height.
Shape Pillow(float width, float depth, float thickness, const PillowOptions& options,
             const Noise& noise);

// A cloth on a table, with its overhang and folds.
struct DrapeOptions {
  Vec2f table{1, 1};  // Extent along x and y of the table below the cloth, centred.
  float edge_radius_m = 0.04f;
  // Overhang on each side: -x, +x, -y, +y; negative = ends before the edge.
  float hang[4] = {0.2f, 0.2f, 0.2f, 0.2f};
  float thickness_m = 0.015f;
  float fold_m = 0.02f;  // Depth of the folds where it hangs.
  float fold_size_m = 0.15f;
  float wrinkle_m = 0.006f;  // On top.
  float wrinkle_size_m = 0.25f;
  float target_edge_m = 0.03f;
  float flare = 0.08f;  // Distance of the hanging part from the side, in its lengths.
};

// A cloth whose underside rests on the plane z = 0 of the table and hangs over its sides.
Shape Drape(const DrapeOptions& options, const Noise& noise);

}  // namespace parallax::kernel
