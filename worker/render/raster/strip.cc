#include "worker/render/raster/strip.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/render/raster/rasteriser.h"

namespace parallax {
namespace {

constexpr int kSamples = VisibilityBuffer::kSamples;
constexpr int kVectors = kSamples / kLanes;  // Vectors of a pixel's samples.

float Least(Float8 x) {
  const __m128 half = _mm_min_ps(_mm256_castps256_ps128(x), _mm256_extractf128_ps(x, 1));
  const __m128 quarter = _mm_min_ps(half, _mm_movehl_ps(half, half));
  return _mm_cvtss_f32(_mm_min_ss(quarter, _mm_movehdup_ps(quarter)));
}

// Part of a row of pixels that a triangle with these corners may cover, as [from, to] in pixels.
// Widens for rounding.
[[gnu::always_inline]] inline void BoundRow(const float x[3], const float y[3], int row,
                                            float* from, float* to) {
  const float above = static_cast<float>(row), below = above + 1;
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (int k = 0; k < 3; ++k) {
    float ax = x[k], ay = y[k], bx = x[(k + 1) % 3], by = y[(k + 1) % 3];
    if (ay > by) {
      std::swap(ax, bx);
      std::swap(ay, by);
    }
    if (by < above || ay > below) continue;
    const float slope = by > ay ? (bx - ax) / (by - ay) : 0;
    const float p = ay < above ? ax + (above - ay) * slope : ax;
    const float q = by > below ? ax + (below - ay) * slope : bx;
    low = std::min({low, p, q});
    high = std::max({high, p, q});
  }
  const float largest = std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2]), std::abs(y[0]),
                                  std::abs(y[1]), std::abs(y[2])});
  const float margin = 0.01f + 1e-6f * largest;
  *from = low - margin;
  *to = high + margin;
}

}  // namespace

// Eight triangles in the picture, seen from the side from which they turn clockwise on the screen.
struct Strip::Triangles8 {
  alignas(32) float x[3][kLanes];  // Pixels.
  alignas(32) float y[3][kLanes];
  alignas(32) float w[3][kLanes];  // 1/z of the corners over twice the area.
  alignas(32) float nearest[kLanes];
  alignas(32) float farthest[kLanes];
  alignas(32) int32_t x0[kLanes];  // Pixels that they may cover, ends included.
  alignas(32) int32_t x1[kLanes];
  alignas(32) int32_t y0[kLanes];
  alignas(32) int32_t y1[kLanes];
};

Strip::Strip(int width)
    : width_(width),
      tiles_x_((width + kTile - 1) / kTile),
      inverse_z_(static_cast<size_t>(width) * kRows * kSamples),
      farthest_(static_cast<size_t>(width) * kRows),
      farthest_of_tile_(static_cast<size_t>(tiles_x_) * (kRows / kTile)),
      stale_(farthest_of_tile_.size()) {}

void Strip::Clear(int first_row, int rows) {
  first_row_ = first_row;
  rows_ = rows;
  std::fill(inverse_z_.begin(), inverse_z_.end(), 0.0f);
  std::fill(farthest_.begin(), farthest_.end(), 0.0f);
  std::fill(farthest_of_tile_.begin(), farthest_of_tile_.end(), 0.0f);
  std::fill(stale_.begin(), stale_.end(), uint8_t{0});
}

float Strip::FarthestOf(int tile_x, int tile_y) {
  const auto tile = static_cast<size_t>(tile_y * tiles_x_ + tile_x);
  if (stale_[tile] != 0) {
    stale_[tile] = 0;
    float least = std::numeric_limits<float>::infinity();
    const int x1 = std::min((tile_x + 1) * kTile, width_);
    for (int y = tile_y * kTile; y < std::min((tile_y + 1) * kTile, rows_); ++y) {
      for (int x = tile_x * kTile; x < x1; ++x) {
        least = std::min(least, farthest_[static_cast<size_t>(y * width_ + x)]);
      }
    }
    farthest_of_tile_[tile] = least;
  }
  return farthest_of_tile_[tile];
}

// Whether every pixel that the cluster may cover shows something nearer.
bool Strip::Hidden(const PlacedCluster& placed) {
  const int first = first_row_ / kTile;
  const TileRect& tiles = placed.tiles;
  const int y0 = std::max(tiles.y0 - first, 0), y1 = std::min(tiles.y1 - first, kRows / kTile - 1);
  for (int y = y0; y <= y1 && y * kTile < rows_; ++y) {
    for (int x = tiles.x0; x <= tiles.x1; ++x) {
      if (!(FarthestOf(x, y) > placed.nearest)) return false;
    }
  }
  return true;
}

// Whether the triangle of id `a` wins over that of `b` where both are equally near.
bool Strip::Comes(uint32_t a, uint32_t b) const {
  const SeenTriangle mine = buffer_->TriangleOf(a), other = buffer_->TriangleOf(b);
  return mine.body != other.body ? mine.body < other.body : mine.triangle < other.triangle;
}

Mask8 Strip::BeforeThoseThere(Mask8 equal, Int8 there, uint32_t id) const {
  for (uint32_t left = BitsOf(equal); left != 0; left &= left - 1) {
    const int lane = __builtin_ctz(left);
    if (!Comes(id, static_cast<uint32_t>(there[lane]))) equal[lane] = 0;
  }
  return equal;
}

// Writes image points of the cluster's vertices to corners_; without `divide`, homogeneous ones.
[[gnu::always_inline]] inline void Strip::Project(const ClusteredMeshes& meshes,
                                                  const PlacedCluster& placed, bool divide) {
  const Cluster& cluster = meshes.clusters[placed.cluster];
  const Eigen::Matrix<float, 3, 4>& m = *placed.image_from_mesh;
  const auto load = [&](const std::vector<float>& row, uint32_t k) -> Float8 {
    return _mm256_loadu_ps(&row[cluster.first_vertex + k]);
  };
  for (uint32_t k = 0; k < cluster.vertices; k += kLanes) {
    const Float8 x = load(meshes.x, k), y = load(meshes.y, k), z = load(meshes.z, k);
    const auto row = [&](int r) { return m(r, 0) * x + m(r, 1) * y + (m(r, 2) * z + m(r, 3)); };
    Float8 px = row(0), py = row(1), pz = row(2);
    if (divide) {
      pz = 1.0f / pz;
      px *= pz;
      py *= pz;
    }
    const __m256 xy = _mm256_unpacklo_ps(px, py), xy2 = _mm256_unpackhi_ps(px, py);
    const __m256 zero = _mm256_setzero_ps();
    const __m256 zw = _mm256_unpacklo_ps(pz, zero), zw2 = _mm256_unpackhi_ps(pz, zero);
    const __m256 pairs[4] = {_mm256_shuffle_ps(xy, zw, 0x44), _mm256_shuffle_ps(xy, zw, 0xee),
                             _mm256_shuffle_ps(xy2, zw2, 0x44), _mm256_shuffle_ps(xy2, zw2, 0xee)};
    for (uint32_t i = 0; i < 4; ++i) {
      _mm_store_ps(corners_ + 4 * (k + i), _mm256_castps256_ps128(pairs[i]));
      _mm_store_ps(corners_ + 4 * (k + i + 4), _mm256_extractf128_ps(pairs[i], 1));
    }
  }
}

// Draws one triangle into the samples that it covers. Edge functions are differences from the
// sample, so that both triangles of an edge get exactly opposite values: no sample falls between.
[[gnu::always_inline]] inline void Strip::DrawTriangle(const Triangles8& triangles, int lane,
                                                       uint32_t id) {
  constexpr float kBeyond = 1e6f;  // Further right than pictures reach.
  constexpr int kWide = 4;         // Pixels, from which on the bounds of each row are worthwhile.
  float x[3], y[3], w[3];
  for (int k = 0; k < 3; ++k) {
    x[k] = triangles.x[k][lane];
    y[k] = triangles.y[k][lane];
    w[k] = triangles.w[k][lane];
  }
  const float nearest = triangles.nearest[lane], farthest = triangles.farthest[lane];
  const int x0 = triangles.x0[lane], x1 = triangles.x1[lane];
  for (int row = triangles.y0[lane]; row <= triangles.y1[lane]; ++row) {
    int from = x0, to = x1;
    if (x1 - x0 >= kWide) {
      float low, high;
      BoundRow(x, y, row, &low, &high);
      from = std::max(from, static_cast<int>(std::clamp(low, 0.0f, kBeyond)));
      to = std::min(to, static_cast<int>(std::clamp(high, 0.0f, kBeyond)));
    }
    size_t pixel = static_cast<size_t>((row - first_row_) * width_ + from);
    uint32_t* ids = buffer_->Ids(from, row);
    for (int column = from; column <= to; ++column, ++pixel, ids += kSamples) {
      if (farthest_[pixel] > nearest) continue;
      const float* const u = buffer_->points().X(column, row);
      const float* const v = buffer_->points().Y(column, row);
      const auto left = static_cast<float>(column), top = static_cast<float>(row);
      Float8 now[kVectors];
      bool drawn = false;
      for (int part = 0; part < kVectors; ++part) {
        const Float8 at_x = _mm256_load_ps(u + part * kLanes);
        const Float8 at_y = _mm256_load_ps(v + part * kLanes);
        Float8 dx[3], dy[3];
        for (int k = 0; k < 3; ++k) {
          dx[k] = (x[k] - left) - at_x;
          dy[k] = (y[k] - top) - at_y;
        }
        const Float8 e0 = dx[1] * dy[2] - dx[2] * dy[1];
        const Float8 e1 = dx[2] * dy[0] - dx[0] * dy[2];
        const Float8 e2 = dx[0] * dy[1] - dx[1] * dy[0];
        const Mask8 inside = Min(Min(e0, e1), e2) >= 0.0f;
        // Rounding may not lead beyond the corners: else what pixels and clusters hide would depend
        // on the order of drawing.
        const Float8 inverse_z = Min(Max(e0 * w[0] + e1 * w[1] + e2 * w[2], farthest), nearest);
        float* const depths = &inverse_z_[pixel * kSamples + static_cast<size_t>(part * kLanes)];
        const Float8 there = _mm256_loadu_ps(depths);
        now[part] = there;
        Mask8 wins = inside & (inverse_z >= there);
        if (!Any(wins)) continue;
        const Mask8 equal = wins & (inverse_z == there);
        __m256i* const to_ids = reinterpret_cast<__m256i*>(ids + part * kLanes);
        const auto ids_there = (Int8)_mm256_loadu_si256(to_ids);
        if (Any(equal)) [[unlikely]] {
          wins &= ~equal | BeforeThoseThere(equal, ids_there, id);
        }
        now[part] = wins ? inverse_z : there;
        _mm256_storeu_ps(depths, now[part]);
        _mm256_storeu_si256(to_ids,
                            (__m256i)(wins ? Int8{} + static_cast<int32_t>(id) : ids_there));
        drawn = true;
      }
      if (!drawn) continue;
      Float8 all = now[0];
      for (int part = 1; part < kVectors; ++part) all = Min(all, now[part]);
      const float least = Least(all);
      if (least > farthest_[pixel]) {
        farthest_[pixel] = least;
        stale_[static_cast<size_t>((row - first_row_) / kTile * tiles_x_ + column / kTile)] = 1;
      }
    }
  }
}

// Sets up and draws those of eight triangles whose `lanes` are set. `corners` are image points with
// 1/z; the ids count up from the first.
[[gnu::always_inline]] inline void Strip::DrawEight(Vec3x8 a, Vec3x8 b, Vec3x8 c, Mask8 lanes,
                                                    uint32_t first_id) {
  Float8 area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
  const Mask8 turned = area < 0.0f;
  const Vec3x8 second = Select(turned, c, b), third = Select(turned, b, c);
  area = Abs(area);
  const Float8 left = Min(Min(a.x, b.x), c.x), right = Max(Max(a.x, b.x), c.x);
  const Float8 top = Min(Min(a.y, b.y), c.y), bottom = Max(Max(a.y, b.y), c.y);
  const auto first = static_cast<float>(first_row_), rows = static_cast<float>(rows_);
  const auto width = static_cast<float>(width_);
  lanes &=
      (area > 0.0f) & (right > 0.0f) & (left < width) & (bottom > first) & (top < first + rows);
  if (!Any(lanes)) return;
  const Int8 x0 = ToInt(Clamp(left, 0.0f, width - 1)), x1 = ToInt(Clamp(right, 0.0f, width - 1));
  const Int8 y0 = ToInt(Clamp(top, first, first + rows - 1));
  const Int8 y1 = ToInt(Clamp(bottom, first, first + rows - 1));
  const Float8 nearest = Max(Max(a.z, b.z), c.z);
  // Most are smaller than a pixel, and hidden.
  const Int8 pixel = (y0 - first_row_) * width_ + x0;
  const Mask8 single = (x0 == x1) & (y0 == y1);
  lanes &= ~(single & (Gather(farthest_.data(), lanes ? pixel : Int8{}) > nearest));
  if (!Any(lanes)) return;

  Triangles8 all;
  const Float8 scale = 1.0f / area;
  const Vec3x8* const corners[3] = {&a, &second, &third};
  for (int k = 0; k < 3; ++k) {
    _mm256_store_ps(all.x[k], corners[k]->x);
    _mm256_store_ps(all.y[k], corners[k]->y);
    _mm256_store_ps(all.w[k], corners[k]->z * scale);
  }
  _mm256_store_ps(all.nearest, nearest);
  _mm256_store_ps(all.farthest, Min(Min(a.z, b.z), c.z));
  const auto store = [](int32_t* to, Int8 x) {
    _mm256_store_si256(reinterpret_cast<__m256i*>(to), (__m256i)x);
  };
  store(all.x0, x0);
  store(all.x1, x1);
  store(all.y0, y0);
  store(all.y1, y1);
  for (uint32_t left_over = BitsOf(lanes); left_over != 0; left_over &= left_over - 1) {
    const int lane = __builtin_ctz(left_over);
    DrawTriangle(all, lane, first_id + static_cast<uint32_t>(lane));
  }
}

// Draws triangles of a cluster that may cross the near plane, each cut there. A new corner is
// computed from the edge's nearer end on, so that it is the same for both triangles of the edge.
void Strip::DrawClipped(const uint32_t* triangles, uint32_t count, uint32_t first_id) {
  constexpr float kNear = Rasteriser::kNearM;
  const auto corner = [&](uint32_t index) { return Vec3f(corners_ + 4 * (index & 255)); };
  const auto cut = [](const Vec3f& front, const Vec3f& behind) -> Vec3f {
    Vec3f at = front + (behind - front) * ((front.z() - kNear) / (front.z() - behind.z()));
    at.z() = kNear;
    return at;
  };
  for (uint32_t k = 0; k < count; ++k) {
    const Vec3f in[3] = {corner(triangles[k]), corner(triangles[k] >> 8),
                         corner(triangles[k] >> 16)};
    Vec3f polygon[4];
    int corners = 0;
    for (int i = 0; i < 3; ++i) {
      const Vec3f &p = in[i], &q = in[(i + 1) % 3];
      const bool p_seen = p.z() >= kNear, q_seen = q.z() >= kNear;
      if (p_seen) polygon[corners++] = p;
      if (p_seen != q_seen) polygon[corners++] = p_seen ? cut(p, q) : cut(q, p);
    }
    for (int i = 0; i < corners; ++i) {
      Vec3f& p = polygon[i];
      p.z() = 1.0f / p.z();
      p.x() *= p.z();
      p.y() *= p.z();
    }
    for (int i = 2; i < corners; ++i) {
      DrawEight(polygon[0], polygon[i - 1], polygon[i], FirstLanes(1), first_id + k);
    }
  }
}

[[gnu::always_inline]] inline void Strip::DrawCluster(const ClusteredMeshes& meshes,
                                                      const PlacedCluster& placed, uint32_t draw) {
  const Cluster& cluster = meshes.clusters[placed.cluster];
  const uint32_t* const triangles = &meshes.triangles[cluster.first_triangle];
  const uint32_t first_id = draw * VisibilityBuffer::kDrawTriangles;
  const bool in_front = std::isfinite(placed.nearest);
  Project(meshes, placed, in_front);
  if (!in_front) return DrawClipped(triangles, cluster.triangles, first_id);
  for (uint32_t k = 0; k < cluster.triangles; k += kLanes) {
    const auto packed = (Int8)_mm256_loadu_si256(reinterpret_cast<const __m256i*>(triangles + k));
    const auto corners = [&](Int8 index) {
      Float8 rows[4];
      GatherFours(corners_, index & 255, 4, rows);
      return Vec3x8(rows[0], rows[1], rows[2]);
    };
    DrawEight(corners(packed), corners(packed >> 8), corners(packed >> 16),
              FirstLanes(cluster.triangles - static_cast<int>(k)), first_id + k);
  }
}

PARALLAX_LANE_CLONES void Strip::Draw(const ClusteredMeshes& meshes,
                                      std::span<const PlacedCluster> clusters,
                                      std::span<const uint32_t> order, int first_row,
                                      VisibilityBuffer* buffer) {
  buffer_ = buffer;
  Clear(first_row, std::min(kRows, buffer->height() - first_row));
  for (const uint32_t draw : order) {
    const PlacedCluster& placed = clusters[draw];
    if (!Hidden(placed)) DrawCluster(meshes, placed, draw);
  }
}

}  // namespace parallax
