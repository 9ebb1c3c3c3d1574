// One eye's picture and the denoiser's guides for it, from the sums of its pixels' samples.
#pragma once

#include <array>
#include <vector>

#include "common/image/image.h"
#include "worker/render/camera/camera.h"
#include "worker/render/paths/path_tracer.h"

namespace parallax {

// Most right eyes of one left eye: each has a bit of Film::ambiguous.
inline constexpr int kMostPartners = 8;

// Pixel coordinates; (0, 0) is the top left.
struct PixelAt {
  int x = 0, y = 0;
};

// Sums over a pixel's samples. The guides are albedo and normal, weighted by each sample.
struct PixelSum {
  Vec3f color = Vec3f::Zero(), albedo = Vec3f::Zero(), normal = Vec3f::Zero();
  float guides = 1e-9f;     // Sum of the guides' weights.
  float guide_squares = 0;  // Weighted sum of squared lengths of albedo and normal.
  bool judged = false;      // Whether samples were compared with the ground truth, and how many of
  std::array<int, kMostPartners> agreeing{};  // them lie within 1 px of its disparity, by partner.
  void Add(const PathResult& path);
  // Returns the variance of the guides within the pixel; large where its samples saw different
  // surfaces.
  float GuideVariance() const;
};

// Collects one eye's pixels. Different pixels may be written at the same time.
class Film {
 public:
  explicit Film(const PinholeCamera& camera);

  // Sets the pixel from `sum` of `samples` samples. Box filter one pixel wide: edges of the picture
  // lie where those of the ground truth do.
  void Develop(const PixelAt& at, const PixelSum& sum, int samples);
  // Adds more samples of the guides, without colour, to those of the pixel.
  void AddGuides(const PixelAt& at, const PixelSum& sum);
  // Returns the pixels whose samples saw different surfaces, judging by the guides: edges and fine
  // patterns, where guides from few samples are too noisy for the denoiser.
  std::vector<PixelAt> MixedPixels() const;

  int width() const { return color.width(); }
  int height() const { return color.height(); }

  ImageF3 color;           // Linear radiance.
  ImageF3 albedo, normal;  // Means; normals in the camera's frame.
  ImageU8 ambiguous;       // Bits, by partner: less than half of the samples lie where the ground
                           // truth does.

 private:
  const Mat3f camera_from_world_;
  ImageF guides_;  // Total weight of each pixel's guides.
  ImageU8 mixed_;
};

}  // namespace parallax
