#include "worker/materials/pictures/mip_picture.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "worker/materials/kernel/surface.h"

namespace parallax {
namespace {

constexpr int kMipPixels = 1024;

Vec3f PixelValue(const uint8_t* p, MipPicture::Values values) {
  if (values == MipPicture::Values::kColor) {
    return Albedo(
        SrgbColor(static_cast<uint32_t>(p[0]) << 16 | static_cast<uint32_t>(p[1]) << 8 | p[2]));
  }
  return Vec3f(p[0], p[1], p[2]) / 255.0f;
}

int Wrapped(int i, int size, MipPicture::Edge edge) {
  if (edge == MipPicture::Edge::kClamp) return std::clamp(i, 0, size - 1);
  const int period = edge == MipPicture::Edge::kMirror ? 2 * size : size;
  const int rest = i % period, at = rest < 0 ? rest + period : rest;
  return at < size ? at : period - 1 - at;
}

// Brings a coordinate close to the picture: integers of pixels must hold it.
float Near(float u, MipPicture::Edge edge) {
  switch (edge) {
    case MipPicture::Edge::kRepeat:
      return u - std::floor(u);
    case MipPicture::Edge::kMirror:
      return u - 2 * std::floor(0.5f * u);
    case MipPicture::Edge::kClamp:
      break;
  }
  return std::clamp(u, -1.0f, 2.0f);
}

}  // namespace

MipPicture::MipPicture(const ImageRgb8& image, Values values, Edges edges) : edges_(edges) {
  const auto pixel = [&](int x, int y) {
    return PixelValue(
        image.At(Wrapped(x, image.width(), edges_.u), Wrapped(y, image.height(), edges_.v)),
        values);
  };
  Level level{image.width(), image.height(), {}};
  if (std::max(level.width, level.height) > kMipPixels) {
    // At full size the floats of a large picture would take four times its own memory.
    level = Halved(level.width, level.height, pixel);
  } else {
    level.pixels.reserve(image.pixels());
    for (int y = 0; y < image.height(); ++y) {
      for (int x = 0; x < image.width(); ++x) level.pixels.push_back(pixel(x, y));
    }
  }
  while (std::max(level.width, level.height) > kMipPixels) level = Halved(level);
  levels_.push_back(std::move(level));
  while (std::max(levels_.back().width, levels_.back().height) > 1) {
    levels_.push_back(Halved(levels_.back()));
  }
}

const Vec3f& MipPicture::Pixel(const Level& level, int x, int y) const {
  x = Wrapped(x, level.width, edges_.u);
  y = Wrapped(y, level.height, edges_.v);
  return level
      .pixels[static_cast<size_t>(y) * static_cast<size_t>(level.width) + static_cast<size_t>(x)];
}

template <typename PixelAt>
MipPicture::Level MipPicture::Halved(int width, int height, const PixelAt& pixel) {
  Level out{std::max(1, width / 2), std::max(1, height / 2), {}};
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      out.pixels.push_back(0.25f * (pixel(2 * x, 2 * y) + pixel(2 * x + 1, 2 * y) +
                                    pixel(2 * x, 2 * y + 1) + pixel(2 * x + 1, 2 * y + 1)));
    }
  }
  return out;
}

MipPicture::Level MipPicture::Halved(const Level& fine) const {
  return Halved(fine.width, fine.height, [&](int x, int y) { return Pixel(fine, x, y); });
}

Vec3f MipPicture::Bilinear(const Level& level, float u, float v) const {
  const float x = u * static_cast<float>(level.width) - 0.5f;
  const float y = v * static_cast<float>(level.height) - 0.5f;
  const int i = noise::FloorInt(x), j = noise::FloorInt(y);
  const float s = x - static_cast<float>(i), t = y - static_cast<float>(j);
  return Mix(Mix(Pixel(level, i, j), Pixel(level, i + 1, j), s),
             Mix(Pixel(level, i, j + 1), Pixel(level, i + 1, j + 1), s), t);
}

Vec3f MipPicture::At(float u, float v, float width) const {
  const auto size = static_cast<float>(std::max(levels_[0].width, levels_[0].height));
  const float level = std::clamp(std::log2(std::max(1e-6f, width * size)), 0.0f,
                                 static_cast<float>(levels_.size() - 1));
  u = Near(u, edges_.u);
  v = Near(v, edges_.v);
  const auto low = static_cast<size_t>(level);
  const size_t high = std::min(low + 1, levels_.size() - 1);
  return Mix(Bilinear(levels_[low], u, 1 - v), Bilinear(levels_[high], u, 1 - v),
             level - static_cast<float>(low));
}

}  // namespace parallax
