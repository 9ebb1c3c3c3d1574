// What the two eyes of a rig lend each other before their pictures are denoised: where both see the
// same piece of a surface that looks alike from either, the light that one eye's paths found counts
// in the other's picture too. Nearly everything in a picture is seen by both, so paths count almost
// twice. Samples of the sky, of glass, mirrors and gloss, and of what only one eye sees, stay where
// they are.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/image/image.h"
#include "common/math/types.h"

namespace parallax {

// One path through a pixel.
struct EyeSample {
  float x_px = 0;        // Where it went through its picture.
  float depth_m = 0;     // Of the first surface, along the optical axis; 0: not to be lent.
  uint32_t surface = 0;  // Names that surface.
  std::array<Eigen::half, 3> radiance, albedo;
};

// All of one eye.
class EyeSamples {
 public:
  EyeSamples() = default;  // Of no picture.
  EyeSamples(int width, int height, int per_pixel)
      : width_(width), height_(height), per_pixel_(per_pixel) {
    samples_.resize(static_cast<size_t>(width) * static_cast<size_t>(height) *
                    static_cast<size_t>(per_pixel));
  }
  bool empty() const { return samples_.empty(); }
  int width() const { return width_; }
  int height() const { return height_; }
  int per_pixel() const { return per_pixel_; }
  // The first of a pixel's samples; those of a row's pixels follow each other.
  EyeSample* At(int x, int y) { return &samples_[Index(x, y)]; }
  const EyeSample* At(int x, int y) const { return &samples_[Index(x, y)]; }

 private:
  size_t Index(int x, int y) const {
    return (static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x)) *
           static_cast<size_t>(per_pixel_);
  }
  int width_ = 0, height_ = 0, per_pixel_ = 0;
  std::vector<EyeSample> samples_;
};

// Adds to one eye's picture what the other eye's samples know of it. A sample at depth z and at x
// in the other's picture is at x + `shift_px_m` / z in this one: focal length times baseline for
// the left eye's picture, the negative of it for the right eye's. A pixel's parts of one surface
// keep their weight: what is lent changes their light, not their edges.
void BorrowSamples(const EyeSamples& own, const EyeSamples& other, double shift_px_m,
                   ImageF3* color, ImageF3* albedo);

}  // namespace parallax
