#include "worker/render/film/film.h"

namespace parallax {
namespace {

// Variance of the guides, albedo and normal together, within a pixel. A pixel a tenth of which
// shows something at a right angle to the rest has 0.18.
constexpr float kMixed = 0.03f;

}  // namespace

void PixelSum::Add(const PathResult& path) {
  color += path.radiance;
  albedo += path.guide_weight * path.albedo;
  normal += path.guide_weight * path.normal;
  guides += path.guide_weight;
  guide_squares += path.guide_weight * (path.albedo.squaredNorm() + path.normal.squaredNorm());
}

float PixelSum::GuideVariance() const {
  return guide_squares / guides - (albedo.squaredNorm() + normal.squaredNorm()) / (guides * guides);
}

Film::Film(const PinholeCamera& camera)
    : color(camera.width_px, camera.height_px),
      albedo(color),
      normal(color),
      ambiguous(camera.width_px, camera.height_px),
      camera_from_world_(camera.world_from_camera.transpose().cast<float>()),
      guides_(camera.width_px, camera.height_px),
      mixed_(camera.width_px, camera.height_px) {}

void Film::Develop(const PixelAt& at, const PixelSum& sum, int samples) {
  for (int c = 0; c < 3; ++c) color(at.x, at.y, c) = sum.color[c] / static_cast<float>(samples);
  mixed_(at.x, at.y) = sum.GuideVariance() > kMixed;
  if (sum.judged) {
    int bits = 0;
    for (size_t k = 0; k < sum.agreeing.size(); ++k) bits |= (2 * sum.agreeing[k] < samples) << k;
    ambiguous(at.x, at.y) = static_cast<uint8_t>(bits);
  }
  guides_(at.x, at.y) = 0;
  AddGuides(at, sum);
}

void Film::AddGuides(const PixelAt& at, const PixelSum& sum) {
  const Vec3f turned = camera_from_world_ * sum.normal;
  float& guides = guides_(at.x, at.y);
  const float had = guides;
  guides += sum.guides;
  for (int c = 0; c < 3; ++c) {
    float& a = albedo(at.x, at.y, c);
    float& n = normal(at.x, at.y, c);
    a = (a * had + sum.albedo[c]) / guides;
    n = (n * had + turned[c]) / guides;
  }
}

std::vector<PixelAt> Film::MixedPixels() const {
  std::vector<PixelAt> pixels;
  for (int y = 0; y < height(); ++y) {
    for (int x = 0; x < width(); ++x) {
      if (mixed_(x, y)) pixels.push_back({x, y});
    }
  }
  return pixels;
}

}  // namespace parallax
