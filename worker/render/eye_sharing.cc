#include "worker/render/eye_sharing.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace parallax {
namespace {

constexpr float kDepthSlack = 0.01f;  // Of a depth, beyond those of the pixel's own samples.

using Light = Eigen::Array<float, 6, 1>;  // Radiance, albedo.

Light LightOf(const EyeSample& sample) {
  Light light;
  for (int c = 0; c < 3; ++c) {
    light[c] = static_cast<float>(sample.radiance[static_cast<size_t>(c)]);
    light[3 + c] = static_cast<float>(sample.albedo[static_cast<size_t>(c)]);
  }
  return light;
}

// The part of a pixel that one surface covers.
struct Part {
  uint32_t surface = 0;
  float nearest = 0, farthest = 0;
  Light own = Light::Zero(), lent = Light::Zero();
  float own_count = 0, lent_count = 0;

  bool Includes(const EyeSample& sample) const {
    return sample.surface == surface && sample.depth_m >= nearest * (1.0f - kDepthSlack) &&
           sample.depth_m <= farthest * (1.0f + kDepthSlack);
  }
  // By which the pixel's sum of samples changes.
  Light Change() const { return own_count * (own + lent) / (own_count + lent_count) - own; }
};

class Pixel {
 public:
  explicit Pixel(std::span<const EyeSample> own) : count_(static_cast<float>(own.size())) {
    for (const EyeSample& sample : own) {
      if (sample.depth_m > 0.0f) AddOwn(sample);
    }
  }

  void Lend(const EyeSample& sample) {
    for (size_t i = 0; i < used_; ++i) {
      if (!parts_[i].Includes(sample)) continue;
      parts_[i].lent += LightOf(sample);
      ++parts_[i].lent_count;
      return;
    }
  }

  // Of the mean of its samples.
  Light Change() const {
    Light change = Light::Zero();
    for (size_t i = 0; i < used_; ++i) {
      if (parts_[i].lent_count > 0.0f) change += parts_[i].Change();
    }
    return change / count_;
  }

 private:
  void AddOwn(const EyeSample& sample) {
    size_t i = 0;
    while (i < used_ && parts_[i].surface != sample.surface) ++i;
    if (i == parts_.size()) return;  // The rest of a crowded pixel is left as it is.
    Part& part = parts_[i];
    if (i == used_) {
      ++used_;
      part.surface = sample.surface;
      part.nearest = part.farthest = sample.depth_m;
    }
    part.nearest = std::min(part.nearest, sample.depth_m);
    part.farthest = std::max(part.farthest, sample.depth_m);
    part.own += LightOf(sample);
    ++part.own_count;
  }

  const float count_;
  std::array<Part, 4> parts_;
  size_t used_ = 0;
};

void BorrowRow(const EyeSamples& own, const EyeSamples& other, int y, float shift_px_m,
               ImageF3* color, ImageF3* albedo) {
  const auto per_pixel = static_cast<size_t>(own.per_pixel());
  const auto width = static_cast<size_t>(own.width());
  const std::span<const EyeSample> lenders(other.At(0, y), width * per_pixel);
  // By pixel, the sample that was put there last; of each, the one before it. 0: none.
  std::vector<uint32_t> last(width), before(lenders.size() + 1);
  for (size_t i = 0; i < lenders.size(); ++i) {
    const EyeSample& sample = lenders[i];
    if (!(sample.depth_m > 0.0f)) continue;
    const float x = sample.x_px + shift_px_m / sample.depth_m;
    if (!(x >= 0.0f && x < static_cast<float>(width))) continue;
    const auto pixel = static_cast<size_t>(x);
    before[i + 1] = last[pixel];
    last[pixel] = static_cast<uint32_t>(i + 1);
  }
  for (size_t x = 0; x < width; ++x) {
    if (last[x] == 0) continue;
    const auto column = static_cast<int>(x);
    Pixel pixel({own.At(column, y), per_pixel});
    for (uint32_t i = last[x]; i != 0; i = before[i]) pixel.Lend(lenders[i - 1]);
    const Light change = pixel.Change();
    for (int c = 0; c < 3; ++c) {
      float& radiance = (*color)(column, y, c);
      radiance = std::max(0.0f, radiance + change[c]);
      float& tint = (*albedo)(column, y, c);
      tint = std::clamp(tint + change[3 + c], 0.0f, 1.0f);
    }
  }
}

}  // namespace

void BorrowSamples(const EyeSamples& own, const EyeSamples& other, double shift_px_m,
                   ImageF3* color, ImageF3* albedo) {
  tbb::parallel_for(0, own.height(), [&](int y) {
    BorrowRow(own, other, y, static_cast<float>(shift_px_m), color, albedo);
  });
}

}  // namespace parallax
