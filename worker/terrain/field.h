// A square raster of numbers over the ground: heights, drainage areas, masks.
//
// Sample (column, row) stands at `origin + cell_m * (column, row)`; column runs along +x, row along
// +y, world frame, metres. Values; const members are thread-safe.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "common/math/types.h"

namespace parallax {

// The raster, with its place in the world.
struct Field {
  int size = 0;                  // Samples along each side.
  float cell_m = 1;              // Distance between neighbouring samples.
  Vec2f origin = Vec2f::Zero();  // World position of sample (0, 0).
  std::vector<float> values;     // Row by row, size * size.

  // Returns a field of `size` x `size` samples centred on `center`, filled with `value`.
  static Field Square(int size, float extent_m, const Vec2f& center = Vec2f::Zero(),
                      float value = 0);

  float& At(int column, int row) { return values[Index(column, row)]; }
  float At(int column, int row) const { return values[Index(column, row)]; }
  size_t Index(int column, int row) const {
    return static_cast<size_t>(row) * static_cast<size_t>(size) + static_cast<size_t>(column);
  }
  // Returns the world position of a sample.
  Vec2f PositionOf(int column, int row) const {
    return origin + cell_m * Vec2f(static_cast<float>(column), static_cast<float>(row));
  }
  float extent_m() const { return cell_m * static_cast<float>(size - 1); }
  // Returns whether `p` lies between samples, `margin_m` away from the border.
  bool Covers(const Vec2f& p, float margin_m = 0) const;

  // Interpolates bilinearly. Positions outside the field take the border's value.
  float Sample(const Vec2f& p) const;
  // Interpolates by Catmull-Rom splines in both directions, which gives heights smooth slopes. May
  // overshoot by a few per cent.
  float SampleSmooth(const Vec2f& p) const;
  // Returns the slope (d/dx, d/dy) of SampleSmooth by central differences one cell wide.
  Vec2f Gradient(const Vec2f& p) const;
};

// Calls `work` for each row of a field, on several threads and in any order.
void ForRows(const Field& field, const std::function<void(int row)>& work);

// The least and greatest value; {0, 0} for an empty field.
struct FieldRange {
  float low = 0, high = 0;
};
FieldRange RangeOf(const Field& field);

// Returns the value below which `share` in [0, 1] of the samples lie.
float Quantile(const Field& field, float share);

// Returns the mean over a square window of (2 radius + 1)^2 samples, cut at the border.
Field BoxBlurred(const Field& field, int radius);

}  // namespace parallax
