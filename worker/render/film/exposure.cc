#include "worker/render/film/exposure.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "worker/render/surface/sampling.h"

namespace parallax {
namespace {

// Blocks across an image of any size: the same view has the same exposure at every resolution, and
// a block has so many samples that noise does not lower the logarithm of their mean (with blocks of
// 8 pixels, pictures of few samples came out brighter than their references).
constexpr int kBlocksAcross = 32;

float LuminanceAt(const ImageF3& image, int x, int y) {
  const float* p = image.At(x, y);
  return Luminance(Vec3f(p[0], p[1], p[2]));
}

// Appends the mean luminance of each block, over those pixels of it for which `counts(x, y)`.
template <typename Counts>
void AppendBlockLuminances(const ImageF3& image, const Counts& counts, std::vector<float>* out) {
  const int block = std::max(1, (image.width() + kBlocksAcross / 2) / kBlocksAcross);
  for (int y0 = 0; y0 < image.height(); y0 += block) {
    for (int x0 = 0; x0 < image.width(); x0 += block) {
      double sum = 0;
      int count = 0;
      for (int y = y0; y < std::min(y0 + block, image.height()); ++y) {
        for (int x = x0; x < std::min(x0 + block, image.width()); ++x) {
          if (!counts(x, y)) continue;
          sum += LuminanceAt(image, x, y);
          ++count;
        }
      }
      if (count > 0) out->push_back(static_cast<float>(sum / count));
    }
  }
}

// Returns the geometric mean. Requires at least one value.
float GeometricMean(const std::vector<float>& values, float low, float high) {
  double sum = 0;
  for (const float value : values) sum += std::log(std::clamp(value, low, high));
  return static_cast<float>(std::exp(sum / static_cast<double>(values.size())));
}

float SrgbCurve(float x) {
  return x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1.0f / 2.4f) - 0.055f;
}

}  // namespace

float Lightness(const ImageF3& albedo, const ImageF3& normal) {
  std::vector<float> albedos;
  const auto is_surface = [&](int x, int y) {
    const float* n = normal.At(x, y);
    return n[0] * n[0] + n[1] * n[1] + n[2] * n[2] > 0.01f;
  };
  AppendBlockLuminances(albedo, is_surface, &albedos);
  if (albedos.empty()) return 1;
  return std::max(1.0f, GeometricMean(albedos, 0.01f, 1.0f) / kUsualAlbedo);
}

float AutomaticExposure(const ImageF3& left, const ImageF3& right, float lightness) {
  std::vector<float> luminances;
  const auto all = [](int, int) { return true; };
  AppendBlockLuminances(left, all, &luminances);
  AppendBlockLuminances(right, all, &luminances);
  if (luminances.empty()) return 1;
  std::sort(luminances.begin(), luminances.end());
  const float cap = std::max(luminances[luminances.size() * 95 / 100], 1e-4f);
  const float bright = luminances[luminances.size() * 80 / 100];
  const float typical = GeometricMean(luminances, 1e-4f, cap);
  float exposure =
      lightness * kKey / kUsualLuminance * std::pow(typical / kUsualLuminance, -kAdaptation);
  const float excess = exposure * bright / kBright;
  if (excess > 1.0f) exposure *= std::pow(excess, -kHoldBack);
  return std::min(exposure, kMaxExposure);
}

float RollOff(float value) {
  if (value <= kShoulder) return value;
  return kShoulder +
         (1.0f - kShoulder) * (1.0f - std::exp(-(value - kShoulder) / (1.0f - kShoulder)));
}

float DisplayLevel(float value) {
  return 255.0f * SrgbCurve(RollOff(std::isfinite(value) ? std::max(value, 0.0f) : 0.0f));
}

ImageRgb8 ToSrgb(const ImageF3& radiance, float exposure) {
  ImageRgb8 out(radiance.width(), radiance.height());
  for (size_t i = 0; i < radiance.values().size(); ++i) {
    out.values()[i] = static_cast<uint8_t>(DisplayLevel(radiance.values()[i] * exposure) + 0.5f);
  }
  return out;
}

}  // namespace parallax
