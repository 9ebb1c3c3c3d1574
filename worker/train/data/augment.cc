#include "worker/train/data/augment.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/base/status.h"

namespace parallax {
namespace {

cv::Mat View(const ImageRgb8& image) {
  return cv::Mat(image.height(), image.width(), CV_8UC3, const_cast<uint8_t*>(image.data()));
}

TrainingEye Mirrored(const TrainingEye& eye) {
  TrainingEye result = eye;
  const auto mirror = [](const auto& from, auto& to) {
    for (int y = 0; y < from.height(); ++y) {
      for (int x = 0; x < from.width(); ++x) {
        std::copy_n(from.At(from.width() - 1 - x, y), from.kChannels, to.At(x, y));
      }
    }
  };
  mirror(eye.image, result.image);
  mirror(eye.disparity_px, result.disparity_px);
  mirror(eye.trust, result.trust);
  return result;
}

// The window of `image` resized to width x height, as three planes in [0, 1].
std::vector<float> ResizedPlanes(const ImageRgb8& image, const cv::Rect& window, int width,
                                 int height) {
  const bool shrinks = window.width > width || window.height > height;
  cv::Mat resized;
  cv::resize(View(image)(window), resized, cv::Size(width, height), 0, 0,
             shrinks ? cv::INTER_AREA : cv::INTER_LINEAR);
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  std::vector<float> planes(3 * pixels);
  for (int y = 0; y < height; ++y) {
    const uint8_t* row = resized.ptr<uint8_t>(y);
    for (int x = 0; x < width; ++x) {
      for (size_t c = 0; c < 3; ++c) {
        planes[c * pixels + static_cast<size_t>(y * width + x)] =
            static_cast<float>(row[3 * x + static_cast<int>(c)]) / 255.0f;
      }
    }
  }
  return planes;
}

// One draw of colours: gains and a rotation of hue, applied in a fixed order.
struct ColourChange {
  float brightness = 1, contrast = 1, saturation = 1, gamma = 1;
  float hue = 0;  // Radians about the grey axis.
};

ColourChange DrawColours(Rng rng) {
  ColourChange change;
  change.brightness = static_cast<float>(rng.Uniform(0.6, 1.4));
  change.contrast = static_cast<float>(rng.Uniform(0.6, 1.4));
  change.saturation = static_cast<float>(rng.Uniform(0.0, 1.4));
  change.gamma = static_cast<float>(std::exp2(rng.Uniform(-0.4, 0.4)));
  change.hue = static_cast<float>(rng.Uniform(-0.5, 0.5));
  return change;
}

float GreyOf(float r, float g, float b) { return 0.299f * r + 0.587f * g + 0.114f * b; }

void Apply(const ColourChange& change, std::vector<float>& planes) {
  const size_t pixels = planes.size() / 3;
  float *r = planes.data(), *g = r + pixels, *b = g + pixels;
  double sum = 0;
  for (size_t i = 0; i < pixels; ++i) sum += GreyOf(r[i], g[i], b[i]);
  const auto mean = static_cast<float>(sum / static_cast<double>(pixels)) * change.brightness;
  // Rotation about (1, 1, 1) by the hue's angle: a circulant matrix.
  const float c = std::cos(change.hue), s = std::sin(change.hue) / std::sqrt(3.0f);
  const float own = (1 + 2 * c) / 3, next = (1 - c) / 3 - s, last = (1 - c) / 3 + s;
  const auto tone = [&](float value) {
    return std::pow(
        std::clamp((value * change.brightness - mean) * change.contrast + mean, 0.0f, 1.0f),
        change.gamma);
  };
  for (size_t i = 0; i < pixels; ++i) {
    const float grey = GreyOf(r[i], g[i], b[i]);
    const float red = grey + (r[i] - grey) * change.saturation;
    const float green = grey + (g[i] - grey) * change.saturation;
    const float blue = grey + (b[i] - grey) * change.saturation;
    r[i] = tone(own * red + next * green + last * blue);
    g[i] = tone(last * red + own * green + next * blue);
    b[i] = tone(next * red + last * green + own * blue);
  }
}

void Blur(std::vector<float>& planes, int width, int height, double sigma_px) {
  const size_t pixels = planes.size() / 3;
  for (size_t c = 0; c < 3; ++c) {
    cv::Mat plane(height, width, CV_32F, planes.data() + c * pixels);
    cv::GaussianBlur(plane, plane, cv::Size(), sigma_px, sigma_px, cv::BORDER_REPLICATE);
  }
}

// Adds noise whose distribution is the sum of four uniform bytes: close to normal, and cheap.
void AddNoise(std::vector<float>& planes, double deviation, Rng rng) {
  const auto scale = static_cast<float>(deviation / 147.8);  // sqrt(4 (256^2 - 1) / 12)
  for (float& value : planes) {
    const uint32_t bits = rng.Bits32();
    const int sum =
        static_cast<int>((bits & 255) + (bits >> 8 & 255) + (bits >> 16 & 255) + (bits >> 24));
    value = std::clamp(value + scale * static_cast<float>(sum - 510), 0.0f, 1.0f);
  }
}

// One or two rectangles of 50 to 100 px a side take the mean colour.
void Erase(std::vector<float>& planes, int width, int height, Rng rng) {
  const size_t pixels = planes.size() / 3;
  const int count = rng.UniformInt(1, 2);
  for (int i = 0; i < count; ++i) {
    const int w = std::min(width, rng.UniformInt(50, 100)),
              h = std::min(height, rng.UniformInt(50, 100));
    const int x0 = rng.UniformInt(0, width - w), y0 = rng.UniformInt(0, height - h);
    for (size_t c = 0; c < 3; ++c) {
      float* plane = planes.data() + c * pixels;
      double sum = 0;
      for (size_t p = 0; p < pixels; ++p) sum += plane[p];
      const auto mean = static_cast<float>(sum / static_cast<double>(pixels));
      for (int y = y0; y < y0 + h; ++y) std::fill_n(plane + y * width + x0, w, mean);
    }
  }
}

}  // namespace

absl::StatusOr<CropGeometry> DrawGeometry(const TrainingPair& pair, const TrainSettings& settings,
                                          const Rng& rng) {
  const AugmentSettings& range = settings.augment;
  const int width = pair.left.image.width(), height = pair.left.image.height();
  if (width < settings.crop_width || height < settings.crop_height) {
    return InvalidArgument("a pair of {}x{} px is smaller than the crop of {}x{}", width, height,
                           settings.crop_width, settings.crop_height);
  }
  CropGeometry geometry;
  geometry.flip =
      rng.Child("flip").Bernoulli(range.flip_probability) && !pair.right.disparity_px.empty();
  Rng scales = rng.Child("scale");
  const double scale = scales.Uniform(range.scale_low, range.scale_high);
  const double scale_x = std::exp2(scale + scales.Uniform(-range.stretch, range.stretch));
  const double scale_y = std::exp2(scale + scales.Uniform(-range.stretch, range.stretch));
  geometry.width = std::min(width, static_cast<int>(std::lround(settings.crop_width / scale_x)));
  geometry.height = std::min(height, static_cast<int>(std::lround(settings.crop_height / scale_y)));
  Rng places = rng.Child("place");
  const auto place = [&](int room) {
    return std::min(room, static_cast<int>(places.Uniform() * (room + 1)));
  };
  geometry.x = place(width - geometry.width);
  geometry.y = place(height - geometry.height);
  Rng jitter = rng.Child("y_jitter");
  geometry.y_right = geometry.y;
  if (jitter.Bernoulli(range.y_jitter_probability)) {
    geometry.y_right += jitter.UniformInt(-range.y_jitter_px, range.y_jitter_px);
    geometry.y_right = std::clamp(geometry.y_right, 0, height - geometry.height);
  }
  return geometry;
}

TrainingCrop CutCrop(const TrainingPair& pair, const CropGeometry& g,
                     const TrainSettings& settings) {
  if (g.flip) {
    CropGeometry rest = g;
    rest.flip = false;
    return CutCrop({Mirrored(pair.right), Mirrored(pair.left)}, rest, settings);
  }
  TrainingCrop crop;
  crop.height = settings.crop_height;
  crop.width = settings.crop_width;
  crop.left =
      ResizedPlanes(pair.left.image, {g.x, g.y, g.width, g.height}, crop.width, crop.height);
  crop.right =
      ResizedPlanes(pair.right.image, {g.x, g.y_right, g.width, g.height}, crop.width, crop.height);
  // Truth is not interpolated: between two surfaces none exists.
  const float stretch = static_cast<float>(crop.width) / static_cast<float>(g.width);
  for (int y = 0; y < crop.height; ++y) {
    const int from_y = g.y + (2 * y + 1) * g.height / (2 * crop.height);
    for (int x = 0; x < crop.width; ++x) {
      const int from_x = g.x + (2 * x + 1) * g.width / (2 * crop.width);
      const float disparity = stretch * pair.left.disparity_px(from_x, from_y);
      uint8_t trust = pair.left.trust(from_x, from_y);
      if (disparity >= static_cast<float>(settings.max_disparity)) trust = kNoTruth;
      // Left of the crop's first column the right image is cut away.
      if (trust == kVisible && static_cast<float>(x) - disparity < 0) trust = kOccluded;
      crop.disparity_px.push_back(disparity);
      crop.weight.push_back(trust == kVisible    ? 1.0f
                            : trust == kOccluded ? static_cast<float>(settings.occluded_weight)
                                                 : 0.0f);
    }
  }
  return crop;
}

void ChangeColours(TrainingCrop& crop, const AugmentSettings& settings, const Rng& rng) {
  Rng colours = rng.Child("colour");
  if (colours.Bernoulli(settings.colour_probability)) {
    const bool asymmetric = colours.Bernoulli(settings.asymmetric_probability);
    Apply(DrawColours(rng.Child("colour_left")), crop.left);
    Apply(DrawColours(rng.Child(asymmetric ? "colour_right" : "colour_left")), crop.right);
  }
  Rng blur = rng.Child("blur");
  if (blur.Bernoulli(settings.blur_probability)) {
    const double sigma_px = blur.Uniform(0.2, std::max(0.2, settings.blur_max_px));
    Blur(crop.left, crop.width, crop.height, sigma_px);
    Blur(crop.right, crop.width, crop.height, sigma_px);
  }
  Rng erase = rng.Child("erase");
  if (erase.Bernoulli(settings.erase_probability))
    Erase(crop.right, crop.width, crop.height, erase);
  Rng noise = rng.Child("noise");
  if (noise.Bernoulli(settings.noise_probability)) {
    const double deviation = noise.Uniform(0, settings.noise_max);
    AddNoise(crop.left, deviation, rng.Child("noise_left"));
    AddNoise(crop.right, deviation, rng.Child("noise_right"));
  }
}

absl::StatusOr<TrainingCrop> Augment(const TrainingPair& pair, const TrainSettings& settings,
                                     const Rng& rng) {
  ASSIGN_OR_RETURN(const CropGeometry geometry, DrawGeometry(pair, settings, rng));
  TrainingCrop crop = CutCrop(pair, geometry, settings);
  ChangeColours(crop, settings.augment, rng);
  return crop;
}

}  // namespace parallax
