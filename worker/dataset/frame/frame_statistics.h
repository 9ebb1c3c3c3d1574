// The statistics of a frame: for verdicts, frame.json and the dataset card.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "parallax/v1/scene.pb.h"
#include "worker/dataset/frame/histogram.h"
#include "worker/render/camera/stereo_frame.h"

namespace parallax {

// Statistics of one frame; of the left view unless said otherwise.
struct FrameStatistics {
  double mean_intensity = 0;  // Mean of all 8-bit values.
  double min_depth_m = 0;     // Over both views; 0 when they see no surface.
  double max_depth_m = 0;     // Over both views.
  double max_disparity_px = 0;
  double median_disparity_px = 0;  // To the histogram's bin width; over pixels that see a surface.
  double occluded_fraction = 0;    // Share of all pixels.
  double sky_fraction = 0;         // Share of pixels that see no surface.
  double textured_fraction = 0;    // Share of all pixels that see a surface with texture.
  // WarpCheck's median, 8-bit steps; -1 when nothing could be compared.
  double warp_median_difference = 0;
  Histogram disparity = DisparityHistogram();
  Histogram depth = DepthHistogram();
  std::map<std::string, int64_t> object_pixels;    // By class.
  std::vector<uint32_t> objects_seen;              // By either eye, in any layer.
  std::map<std::string, int64_t> material_pixels;  // By class.
};

// Computes all statistics of a frame; `scene` gives the classes.
FrameStatistics ComputeStatistics(const v1::Scene& scene, const StereoFrame& frame);

// Returns the numbers above by name, for FrameResult.statistics.
std::map<std::string, double> StatisticsByName(const FrameStatistics& statistics);

// Returns the share of all pixels that see a surface (depth > 0) and lie in no textureless region.
// A region is textureless where the squared horizontal gradient of the 8-bit intensity, averaged
// over a square window, is below a threshold. Source: Scharstein and Szeliski, "A Taxonomy and
// Evaluation of Dense Two-Frame Stereo Correspondence Algorithms", 2002, section 5.1, with their
// threshold and a larger window, because pictures are larger now.
double TexturedFraction(const ImageRgb8& color, const ImageF& depth_m);

// Returns the class of an object for tables; "Unknown" if the recipe does not say.
std::string ClassOf(const v1::SceneObject& object);

// Difference between the left image and the right image warped by the left disparity, outside
// occlusions.
struct WarpDifference {
  // Median absolute difference in 8-bit steps, over pixels and channels; -1: no pixel compared.
  double median = -1;
  double mean = 0;
  double p90 = 0;
  int64_t pixels = 0;
};

// Compares every `stride`-th pixel in x and y. Source: the dataset format, "right warped by
// disparity gives left".
WarpDifference WarpCheck(const ImageRgb8& left, const ImageRgb8& right,
                         const ImageF& left_disparity_px, const ImageU8& left_occlusion,
                         int stride = 1);

}  // namespace parallax
