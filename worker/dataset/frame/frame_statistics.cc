#include "worker/dataset/frame/frame_statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "worker/dataset/frame/frame_images.h"
#include "worker/scene/types/scene_types.h"

namespace parallax {
namespace {

// Counts of each 16-bit value.
std::vector<int64_t> CountIndices(const ImageU16& image) {
  std::vector<int64_t> counts(1 << 16);
  for (const uint16_t value : image.values()) ++counts[value];
  return counts;
}

double Mean(const ImageRgb8& image) {
  const int64_t sum = std::accumulate(image.values().begin(), image.values().end(), int64_t{0});
  return image.empty() ? 0 : static_cast<double>(sum) / static_cast<double>(image.values().size());
}

void AddDepths(const ImageF& depth_m, FrameStatistics& statistics) {
  for (const float depth : depth_m.values()) {
    if (depth <= 0) continue;
    if (statistics.min_depth_m == 0 || depth < statistics.min_depth_m)
      statistics.min_depth_m = depth;
    if (depth > statistics.max_depth_m) statistics.max_depth_m = depth;
  }
}

double Median(const Histogram& histogram) {
  const int64_t half = (histogram.Total() + 1) / 2;
  int64_t sum = 0;
  for (size_t i = 0; half > 0 && i < histogram.counts.size(); ++i) {
    sum += histogram.counts[i];
    if (sum >= half) return (static_cast<double>(i) + 0.5) * histogram.bin_width;
  }
  return 0;
}

// The objects in any map of objects, ascending, 0 left out.
std::vector<uint32_t> ObjectsSeen(const StereoFrame& frame) {
  std::vector<bool> is_seen(1 << 16);
  for (const auto& [file, image] : ImagesOf(frame)) {
    const auto* indices = std::get_if<const ImageU16*>(&image);
    if (!file.starts_with("objects") || !indices) continue;
    for (const uint16_t index : (*indices)->values()) is_seen[index] = true;
  }
  std::vector<uint32_t> seen;
  for (uint32_t i = 1; i < is_seen.size(); ++i) {
    if (is_seen[i]) seen.push_back(i);
  }
  return seen;
}

// Counts the pixels of objects that the place's rules made.
void AddGrown(const v1::Scene& scene, const std::vector<int64_t>& pixels,
              FrameStatistics& statistics) {
  const auto type = TypeOf(scene);
  if (!type.ok() || !(*type)->grown) return;
  for (const uint32_t index : statistics.objects_seen) {
    const auto object = (*type)->grown(scene, index);
    if (object && index < pixels.size() && pixels[index] > 0) {
      statistics.object_pixels[ClassOf(*object)] += pixels[index];
    }
  }
}

}  // namespace

FrameStatistics ComputeStatistics(const v1::Scene& scene, const StereoFrame& frame) {
  FrameStatistics statistics;
  const View& left = frame.left;
  const double pixels = static_cast<double>(std::max<size_t>(left.depth_m.pixels(), 1));
  statistics.mean_intensity = Mean(left.color);
  statistics.textured_fraction = TexturedFraction(left.color, left.depth_m);
  AddDepths(left.depth_m, statistics);
  AddDepths(frame.right.depth_m, statistics);

  int64_t sky = 0, occluded = 0;
  for (size_t i = 0; i < left.depth_m.pixels(); ++i) {
    const float depth = left.depth_m.values()[i], disparity = left.disparity_px.values()[i];
    occluded += left.occlusion.values()[i] != 0;
    if (depth <= 0) {
      ++sky;
      continue;
    }
    statistics.depth.Add(depth);
    statistics.disparity.Add(disparity);
    statistics.max_disparity_px = std::max(statistics.max_disparity_px, double{disparity});
  }
  statistics.sky_fraction = static_cast<double>(sky) / pixels;
  statistics.occluded_fraction = static_cast<double>(occluded) / pixels;
  statistics.median_disparity_px = Median(statistics.disparity);

  const std::vector<int64_t> objects = CountIndices(left.objects);
  for (const v1::SceneObject& object : scene.objects()) {
    const int64_t count = object.index() < objects.size() ? objects[object.index()] : 0;
    if (count > 0) statistics.object_pixels[ClassOf(object)] += count;
  }
  statistics.objects_seen = ObjectsSeen(frame);
  AddGrown(scene, objects, statistics);
  const std::vector<int64_t> materials = CountIndices(left.materials);
  for (const v1::SceneMaterial& material : scene.materials()) {
    const int64_t count = material.index() < materials.size() ? materials[material.index()] : 0;
    if (count > 0) statistics.material_pixels[material.material_class()] += count;
  }

  // A sixteenth of the pixels is enough for the median of every frame of a dataset.
  statistics.warp_median_difference =
      WarpCheck(left.color, frame.right.color, left.disparity_px, left.occlusion, 4).median;
  return statistics;
}

std::map<std::string, double> StatisticsByName(const FrameStatistics& s) {
  return {{"mean_intensity", s.mean_intensity},
          {"min_depth_m", s.min_depth_m},
          {"max_depth_m", s.max_depth_m},
          {"max_disparity_px", s.max_disparity_px},
          {"median_disparity_px", s.median_disparity_px},
          {"occluded_fraction", s.occluded_fraction},
          {"sky_fraction", s.sky_fraction},
          {"textured_fraction", s.textured_fraction},
          {"warp_median_difference", s.warp_median_difference}};
}

double TexturedFraction(const ImageRgb8& color, const ImageF& depth_m) {
  constexpr int kWindowRadius = 4;
  // The threshold of 4 belongs to the mean of three channels; the code squares their sum.
  constexpr int64_t kLeastSquare = 4 * 3 * 3;
  if (color.empty()) return 0;
  const int width = color.width(), height = color.height();
  // Sums of squared gradients over all pixels above and to the left, so that a window takes four.
  const auto stride = static_cast<size_t>(width) + 1;
  std::vector<int64_t> sums(stride * (static_cast<size_t>(height) + 1));
  const auto sum = [&](int x, int y) -> int64_t& {
    return sums[static_cast<size_t>(y) * stride + static_cast<size_t>(x)];
  };
  const auto intensity = [&](int x, int y) {
    return color(x, y, 0) + color(x, y, 1) + color(x, y, 2);
  };
  for (int y = 0; y < height; ++y) {
    int64_t row = 0;
    for (int x = 0; x < width; ++x) {
      const int64_t gradient = x + 1 < width ? intensity(x + 1, y) - intensity(x, y) : 0;
      row += gradient * gradient;
      sum(x + 1, y + 1) = sum(x + 1, y) + row;
    }
  }
  int64_t textured = 0;
  for (int y = 0; y < height; ++y) {
    const int y0 = std::max(y - kWindowRadius, 0), y1 = std::min(y + kWindowRadius + 1, height);
    for (int x = 0; x < width; ++x) {
      if (depth_m(x, y) <= 0) continue;
      const int x0 = std::max(x - kWindowRadius, 0), x1 = std::min(x + kWindowRadius + 1, width);
      const int64_t total = sum(x1, y1) - sum(x0, y1) - sum(x1, y0) + sum(x0, y0);
      textured += total >= kLeastSquare * (x1 - x0) * (y1 - y0);
    }
  }
  return static_cast<double>(textured) / static_cast<double>(color.pixels());
}

std::string ClassOf(const v1::SceneObject& object) {
  return object.asset_class().empty() ? "Unknown" : object.asset_class();
}

WarpDifference WarpCheck(const ImageRgb8& left, const ImageRgb8& right,
                         const ImageF& left_disparity_px, const ImageU8& left_occlusion,
                         int stride) {
  // Differences in sixteenths of an 8-bit step.
  constexpr int kParts = 16;
  std::vector<int64_t> counts(256 * kParts);
  WarpDifference result;
  double sum = 0;
  for (int y = 0; y < left.height(); y += stride) {
    for (int x = 0; x < left.width(); x += stride) {
      const float disparity = left_disparity_px(x, y);
      if (disparity <= 0 || left_occlusion(x, y) != 0) continue;
      const float at = static_cast<float>(x) - disparity;
      const int x0 = static_cast<int>(std::floor(at));
      if (x0 < 0 || x0 + 1 >= right.width()) continue;
      const float weight = at - static_cast<float>(x0);
      ++result.pixels;
      for (int c = 0; c < 3; ++c) {
        const float warped = static_cast<float>(right(x0, y, c)) * (1 - weight) +
                             static_cast<float>(right(x0 + 1, y, c)) * weight;
        const float difference = std::abs(warped - static_cast<float>(left(x, y, c)));
        sum += difference;
        ++counts[static_cast<size_t>(std::lround(difference * kParts))];
      }
    }
  }
  if (result.pixels == 0) return result;
  const int64_t total = 3 * result.pixels;
  result.mean = sum / static_cast<double>(total);
  int64_t below = 0;
  result.median = -1;
  for (size_t i = 0; i < counts.size(); ++i) {
    below += counts[i];
    if (result.median < 0 && 2 * below >= total) result.median = static_cast<double>(i) / kParts;
    if (10 * below >= 9 * total) {
      result.p90 = static_cast<double>(i) / kParts;
      break;
    }
  }
  return result;
}

}  // namespace parallax
