#include "worker/terrain/field.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace parallax {
namespace {

// Where a position falls along one axis: the sample before it and the fraction behind that.
struct Place {
  int sample = 0;
  float fraction = 0;
};

Place PlaceOn(float coordinate, float origin, float cell_m, int size) {
  const float in_cells =
      std::clamp((coordinate - origin) / cell_m, 0.0f, static_cast<float>(size - 1));
  const int sample = std::min(static_cast<int>(in_cells), size - 2);
  return {sample, in_cells - static_cast<float>(sample)};
}

float CatmullRom(float a, float b, float c, float d, float t) {
  return b + 0.5f * t *
                 (c - a + t * (2.0f * a - 5.0f * b + 4.0f * c - d + t * (3.0f * (b - c) + d - a)));
}

}  // namespace

Field Field::Square(int size, float extent_m, const Vec2f& center, float value) {
  Field field;
  field.size = size;
  field.cell_m = extent_m / static_cast<float>(size - 1);
  field.origin = center - Vec2f::Constant(0.5f * extent_m);
  field.values.assign(static_cast<size_t>(size) * static_cast<size_t>(size), value);
  return field;
}

bool Field::Covers(const Vec2f& p, float margin_m) const {
  const Vec2f local = p - origin;
  return local.minCoeff() >= margin_m && local.maxCoeff() <= extent_m() - margin_m;
}

float Field::Sample(const Vec2f& p) const {
  const Place x = PlaceOn(p.x(), origin.x(), cell_m, size);
  const Place y = PlaceOn(p.y(), origin.y(), cell_m, size);
  const float* row = &values[Index(x.sample, y.sample)];
  const float low = row[0] + (row[1] - row[0]) * x.fraction;
  const float high = row[size] + (row[size + 1] - row[size]) * x.fraction;
  return low + (high - low) * y.fraction;
}

float Field::SampleSmooth(const Vec2f& p) const {
  const Place x = PlaceOn(p.x(), origin.x(), cell_m, size);
  const Place y = PlaceOn(p.y(), origin.y(), cell_m, size);
  float rows[4];
  for (int j = 0; j < 4; ++j) {
    const int row = std::clamp(y.sample + j - 1, 0, size - 1);
    const auto value = [&](int i) { return At(std::clamp(x.sample + i, 0, size - 1), row); };
    rows[j] = CatmullRom(value(-1), value(0), value(1), value(2), x.fraction);
  }
  return CatmullRom(rows[0], rows[1], rows[2], rows[3], y.fraction);
}

Vec2f Field::Gradient(const Vec2f& p) const {
  const float half = 0.5f * cell_m;
  const Vec2f along_x(half, 0), along_y(0, half);
  return Vec2f(SampleSmooth(p + along_x) - SampleSmooth(p - along_x),
               SampleSmooth(p + along_y) - SampleSmooth(p - along_y)) /
         cell_m;
}

void ForRows(const Field& field, const std::function<void(int row)>& work) {
  tbb::parallel_for(0, field.size, [&](int row) { work(row); });
}

FieldRange RangeOf(const Field& field) {
  if (field.values.empty()) return {};
  const auto [low, high] = std::minmax_element(field.values.begin(), field.values.end());
  return {*low, *high};
}

float Quantile(const Field& field, float share) {
  if (field.values.empty()) return 0;
  std::vector<float> values = field.values;
  const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<float>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<size_t>(rank)];
}

Field BoxBlurred(const Field& field, int radius) {
  Field across = field, result = field;
  const int n = field.size;
  const auto blur = [n, radius](auto&& read, auto&& write) {
    double sum = 0;
    int count = 0;
    for (int i = 0; i < std::min(radius, n); ++i) sum += read(i), ++count;
    for (int i = 0; i < n; ++i) {
      if (i + radius < n) sum += read(i + radius), ++count;
      if (i - radius > 0) sum -= read(i - radius - 1), --count;
      write(i, static_cast<float>(sum / count));
    }
  };
  for (int row = 0; row < n; ++row) {
    blur([&](int i) { return field.At(i, row); }, [&](int i, float v) { across.At(i, row) = v; });
  }
  for (int column = 0; column < n; ++column) {
    blur([&](int i) { return across.At(column, i); },
         [&](int i, float v) { result.At(column, i) = v; });
  }
  return result;
}

}  // namespace parallax
