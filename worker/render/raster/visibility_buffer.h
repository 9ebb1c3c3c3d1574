// The triangle that an eye sees first at each of some points of each pixel.
//
// Source: Burns and Hunt, "The visibility buffer", JCGT 2013.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/math/types.h"

namespace parallax {

// Points within pixels, kSamples each: a table of kTile x kTile pixels that repeats over the
// picture. They are Sampler's of a stream, so that two eyes have different ones. Any aligned group
// of 2^n points of a pixel is well distributed.
class SamplePoints {
 public:
  static constexpr int kLog2Samples = 4;
  static constexpr int kSamples = 1 << kLog2Samples;
  static constexpr int kTile = 32;

  explicit SamplePoints(uint32_t stream_hash);

  // Return the offsets of a pixel's points from its corner, in [0, 1): kSamples numbers, aligned
  // for vector lanes.
  const float* X(int x, int y) const { return &x_[Index(x, y)]; }
  const float* Y(int x, int y) const { return &y_[Index(x, y)]; }

 private:
  static size_t Index(int x, int y) {
    return static_cast<size_t>((y % kTile) * kTile + x % kTile) * kSamples;
  }
  using Table = std::array<float, size_t{kTile} * kTile * kSamples>;
  alignas(64) Table x_;
  alignas(64) Table y_;
};

// A triangle of the scene; both as in RawHit.
struct SeenTriangle {
  uint32_t body = 0, triangle = 0;
};

// Rasteriser fills it. 64 bytes a pixel.
class VisibilityBuffer {
 public:
  static constexpr int kSamples = SamplePoints::kSamples;
  static constexpr uint32_t kNothing = ~0u;  // Id where no surface is seen.

  VisibilityBuffer(int width, int height, std::unique_ptr<const SamplePoints> points)
      : width_(width),
        height_(height),
        points_(std::move(points)),
        ids_(static_cast<size_t>(width) * static_cast<size_t>(height) * kSamples, kNothing) {}

  int width() const { return width_; }
  int height() const { return height_; }
  const SamplePoints& points() const { return *points_; }
  // Returns the ids of a pixel's kSamples triangles: equal for equal triangles.
  const uint32_t* Ids(int x, int y) const { return &ids_[Index(x, y)]; }
  uint32_t* Ids(int x, int y) { return &ids_[Index(x, y)]; }
  // Returns the triangle of an id that is not kNothing.
  SeenTriangle TriangleOf(uint32_t id) const {
    const Draw& draw = draws_[id / kDrawTriangles];
    return {draw.body, draw.first_triangle + id % kDrawTriangles};
  }

 private:
  friend class Rasteriser;
  friend class Strip;
  static constexpr uint32_t kDrawTriangles = 128;

  // A cluster of a body.
  struct Draw {
    uint32_t body = 0, first_triangle = 0;
  };

  size_t Index(int x, int y) const {
    return (static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x)) *
           kSamples;
  }

  int width_, height_;
  std::unique_ptr<const SamplePoints> points_;
  std::vector<uint32_t> ids_;
  std::vector<Draw> draws_;
};

}  // namespace parallax
