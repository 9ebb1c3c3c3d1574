// A square raster of numbers over the ground: heights, drainage areas, masks.
//
// Sample (column, row) stands at `origin + cell_m * (column, row)`; column runs along +x, row along
// +y, world frame, metres. Values; const members are thread-safe.
#pragma once

#include <cstddef>
#include <vector>

#include "common/math/types.h"

namespace parallax {

// The raster, with its place in the world.
struct Field {
  int size = 0;                  // Samples along each side.
  float cell_m = 1;              // Distance between neighbouring samples.
  Vec2f origin = Vec2f::Zero();  // World position of sample (0, 0).
  std::vector<float> values;     // Row by row, size * size.

  // A field of `size` x `size` samples centred on `center`, filled with `value`.
  static Field Square(int size, float extent_m, const Vec2f& center = Vec2f::Zero(),
                      float value = 0);

  float& At(int column, int row) { return values[Index(column, row)]; }
  float At(int column, int row) const { return values[Index(column, row)]; }
  size_t Index(int column, int row) const {
    return static_cast<size_t>(row) * static_cast<size_t>(size) + static_cast<size_t>(column);
  }
  // World position of a sample.
  Vec2f PositionOf(int column, int row) const {
    return origin + cell_m * Vec2f(static_cast<float>(column), static_cast<float>(row));
  }
  float extent_m() const { return cell_m * static_cast<float>(size - 1); }
  // Whether `p` lies between samples, `margin_m` away from the border.
  bool Covers(const Vec2f& p, float margin_m = 0) const;

  // Bilinear; positions outside of the field take its border's value.
  float Sample(const Vec2f& p) const;
  // Catmull-Rom in both directions: smooth slopes for heights; may overshoot by some per cent.
  float SampleSmooth(const Vec2f& p) const;
  // Slope of SampleSmooth (d/dx, d/dy) by central differences one cell wide.
  Vec2f Gradient(const Vec2f& p) const;
};

// The least and greatest value; {0, 0} for an empty field.
struct FieldRange {
  float low = 0, high = 0;
};
FieldRange RangeOf(const Field& field);

// The value below which `share` in [0, 1] of the samples lie.
float Quantile(const Field& field, float share);

// Mean over a square window of (2 radius + 1)^2 samples, cut at the border.
Field BoxBlurred(const Field& field, int radius);

}  // namespace parallax
