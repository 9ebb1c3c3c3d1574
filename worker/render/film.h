// One eye's picture and what the denoiser is told about it, from the sums of its pixels' samples.
#pragma once

#include <vector>

#include "common/image/image.h"
#include "worker/render/camera.h"
#include "worker/render/path_tracer.h"

namespace parallax {

struct PixelAt {
  int x = 0, y = 0;
};

// Sums over a pixel's samples. The guides are albedo and normal, weighted by each sample.
struct PixelSum {
  Vec3f color = Vec3f::Zero(), albedo = Vec3f::Zero(), normal = Vec3f::Zero();
  float guides = 1e-9f;     // Weight of all.
  float guide_squares = 0;  // Squared lengths of albedo and normal.
  bool judged = false;      // Whether samples were held against the ground truth,
  int agreeing = 0;         // and how many of them lie within 1 px of its disparity.
  void Add(const PathResult& path);
  // Variance of the guides: what one pixel's samples found differs.
  float GuideVariance() const;
};

// Different pixels may be written at a time.
class Film {
 public:
  explicit Film(const PinholeCamera& camera);

  // The pixel anew. Box filter one pixel wide: edges in the picture are where the ground truth has
  // them.
  void Develop(const PixelAt& at, const PixelSum& sum, int samples);
  // More samples of what guides, without colour, to those that the pixel has.
  void AddGuides(const PixelAt& at, const PixelSum& sum);
  // Pixels whose samples met what differs, as far as the guides say: edges and fine patterns, where
  // guides of few samples are noise to the denoiser.
  std::vector<PixelAt> MixedPixels() const;

  int width() const { return color.width(); }
  int height() const { return color.height(); }

  ImageF3 color;           // Radiance.
  ImageF3 albedo, normal;  // Means; normals in the camera's frame.
  ImageU8 ambiguous;       // 1 where less than half of the samples lie where the ground truth does.

 private:
  const Mat3f camera_from_world_;
  ImageF guides_;  // Weight of the guides that a pixel has.
  ImageU8 mixed_;
};

}  // namespace parallax
