// The page of histograms beside a contact sheet.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/image/image.h"
#include "worker/dataset/frame/histogram.h"

namespace parallax {

struct HistogramData {
  int64_t frames = 0;
  int64_t pixels = 0;  // Pixels of the left images.
  Histogram disparity = DisparityHistogram();
  Histogram depth = DepthHistogram();
  std::map<std::string, int64_t> object_pixels, material_pixels;  // By class.
};

// Sums the histograms in the frames' frame.json. Errors: those of ReadFrameJson.
absl::StatusOr<HistogramData> SumHistograms(const std::vector<std::string>& frame_dirs);

// Draws disparity, with the limits of training code; depth; and classes and materials by share of
// pixels.
ImageRgb8 DrawHistogramPage(const std::string& title, const HistogramData& data);

}  // namespace parallax
