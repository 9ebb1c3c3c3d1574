#include "tests/bench/render/image_error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "common/math/types.h"

namespace parallax::bench {
namespace {

constexpr double kPixelsPerDegree = 67;

// ---- Colour spaces (D65)

Vec3f LinearRgb(const uint8_t* p) {
  Vec3f rgb;
  for (int c = 0; c < 3; ++c) {
    const float v = static_cast<float>(p[c]) / 255.0f;
    rgb[c] = v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f);
  }
  return rgb;
}

const Mat3f& XyzFromRgb() {
  static const Mat3f matrix = (Mat3f() << 0.4123908f, 0.3575843f, 0.1804808f, 0.2126390f,
                               0.7151687f, 0.0721923f, 0.0193308f, 0.1191948f, 0.9505322f)
                                  .finished();
  return matrix;
}
const Vec3f& White() {
  static const Vec3f white = XyzFromRgb() * Vec3f::Ones();
  return white;
}

// Linear opponent space: luminance, red-green, blue-yellow.
Vec3f YccFromRgb(const Vec3f& rgb) {
  const Vec3f n = (XyzFromRgb() * rgb).cwiseQuotient(White());
  return {116 * n.y() - 16, 500 * (n.x() - n.y()), 200 * (n.y() - n.z())};
}
Vec3f RgbFromYcc(const Vec3f& ycc) {
  const float y = (ycc.x() + 16) / 116;
  const Vec3f n(y + ycc.y() / 500, y, y - ycc.z() / 200);
  static const Mat3f inverse = XyzFromRgb().inverse();
  return inverse * n.cwiseProduct(White());
}
// CIELAB with Hunt's effect: colour counts less in the dark.
Vec3f HuntLab(const Vec3f& rgb) {
  const Vec3f n = (XyzFromRgb() * rgb).cwiseQuotient(White());
  const auto f = [](float t) {
    constexpr float d = 6.0f / 29;
    return t > d * d * d ? std::cbrt(t) : t / (3 * d * d) + 4.0f / 29;
  };
  const float l = 116 * f(n.y()) - 16;
  return {l, 0.01f * l * 500 * (f(n.x()) - f(n.y())), 0.01f * l * 200 * (f(n.y()) - f(n.z()))};
}
float HyAb(const Vec3f& a, const Vec3f& b) {
  return std::abs(a.x() - b.x()) + (a - b).tail<2>().norm();
}

// ---- Separable filters, edges repeated

using Plane = ImageF;
using Kernel = std::vector<float>;  // Odd length.

Plane Filter(const Plane& in, const Kernel& along_x, const Kernel& along_y) {
  const int w = in.width(), h = in.height(), r = static_cast<int>(along_x.size()) / 2;
  Plane rows(w, h), out(w, h);
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      float sum = 0;
      for (int k = -r; k <= r; ++k) {
        sum += along_x[static_cast<size_t>(k + r)] * in(std::clamp(x + k, 0, w - 1), y);
      }
      rows(x, y) = sum;
    }
  }
  for (int y = 0; y < h; ++y) {
    for (int k = -r; k <= r; ++k) {
      const float weight = along_y[static_cast<size_t>(k + r)];
      const float* source = rows.At(0, std::clamp(y + k, 0, h - 1));
      float* target = out.At(0, y);
      for (int x = 0; x < w; ++x) target[x] += weight * source[x];
    }
  }
  return out;
}

// Contrast sensitivity of a channel: a sum of two Gaussians a sqrt(pi / b) exp(-pi^2 x^2 / b), x in
// degrees.
Plane Blurred(const Plane& in, double a1, double b1, double a2, double b2) {
  const int r =
      static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * M_PI * M_PI)) * kPixelsPerDegree));
  Kernel kernel[2];
  double total = 0, scale[2] = {a1 * M_PI / b1, a2 * M_PI / b2};
  for (int k = 0; k < 2; ++k) {
    double sum = 0;
    for (int i = -r; i <= r; ++i) {
      const double x = i / kPixelsPerDegree;
      kernel[k].push_back(static_cast<float>(std::exp(-M_PI * M_PI * x * x / (k == 0 ? b1 : b2))));
      sum += kernel[k].back();
    }
    total += scale[k] * sum * sum;
  }
  Plane out = Filter(in, kernel[0], kernel[0]);
  for (float& v : out.values()) v *= static_cast<float>(scale[0] / total);
  if (a2 > 0) {
    const Plane more = Filter(in, kernel[1], kernel[1]);
    for (size_t i = 0; i < out.values().size(); ++i) {
      out.values()[i] += static_cast<float>(scale[1] / total) * more.values()[i];
    }
  }
  return out;
}

struct Perceived {
  std::vector<Vec3f> lab;
  std::vector<float> edges, points;
};

// Strength of a feature in both directions.
std::vector<float> Features(const Plane& y, const Kernel& across, const Kernel& along) {
  const Plane dx = Filter(y, across, along);
  const Plane dy = Filter(y, along, across);
  std::vector<float> out(dx.values().size());
  for (size_t i = 0; i < out.size(); ++i) out[i] = std::hypot(dx.values()[i], dy.values()[i]);
  return out;
}

Perceived Perceive(const ImageRgb8& image) {
  const int w = image.width(), h = image.height();
  std::array<Plane, 3> ycc = {Plane(w, h), Plane(w, h), Plane(w, h)};
  Plane luminance(w, h);
  for (size_t i = 0; i < image.pixels(); ++i) {
    const Vec3f v = YccFromRgb(LinearRgb(image.data() + 3 * i));
    for (size_t c = 0; c < 3; ++c) ycc[c].values()[i] = v[static_cast<int>(c)];
    luminance.values()[i] = (v.x() + 16) / 116;
  }
  ycc[0] = Blurred(ycc[0], 1, 0.0047, 0, 1e-5);
  ycc[1] = Blurred(ycc[1], 1, 0.0053, 0, 1e-5);
  ycc[2] = Blurred(ycc[2], 34.1, 0.04, 13.5, 0.025);
  Perceived seen;
  for (size_t i = 0; i < image.pixels(); ++i) {
    const Vec3f rgb = RgbFromYcc(Vec3f(ycc[0].values()[i], ycc[1].values()[i], ycc[2].values()[i]));
    seen.lab.push_back(HuntLab(rgb.cwiseMax(0.0f).cwiseMin(1.0f)));
  }
  const double sigma = 0.5 * 0.082 * kPixelsPerDegree;
  const int r = static_cast<int>(std::ceil(3 * sigma));
  Kernel gauss, edge, point;
  double sum = 0, edge_sum = 0, plus = 0, minus = 0;
  for (int i = -r; i <= r; ++i) {
    const double g = std::exp(-0.5 * i * i / (sigma * sigma));
    const double p = (i * i / (sigma * sigma) - 1) * g;
    gauss.push_back(static_cast<float>(g));
    edge.push_back(static_cast<float>(-i * g));
    point.push_back(static_cast<float>(p));
    sum += g;
    edge_sum += std::max(0.0, -i * g);
    (p > 0 ? plus : minus) += std::abs(p);
  }
  for (float& v : gauss) v /= static_cast<float>(sum);
  for (float& v : edge) v /= static_cast<float>(edge_sum);
  for (float& v : point) v /= static_cast<float>(v > 0 ? plus : minus);
  seen.edges = Features(luminance, edge, gauss);
  seen.points = Features(luminance, point, gauss);
  return seen;
}

}  // namespace

double MeanFlip(const ImageRgb8& picture, const ImageRgb8& reference) {
  const Perceived a = Perceive(picture);
  const Perceived b = Perceive(reference);
  const float largest = std::pow(HyAb(HuntLab(Vec3f::UnitY()), HuntLab(Vec3f::UnitZ())), 0.7f);
  const float knee = 0.4f * largest;
  double sum = 0;
  for (size_t i = 0; i < a.lab.size(); ++i) {
    const float d = std::pow(HyAb(a.lab[i], b.lab[i]), 0.7f);
    const float color = d < knee ? 0.95f * d / knee : 0.95f + 0.05f * (d - knee) / (largest - knee);
    const float feature =
        std::sqrt(std::max(std::abs(a.edges[i] - b.edges[i]), std::abs(a.points[i] - b.points[i])) *
                  std::sqrt(0.5f));
    sum += std::pow(color, 1.0f - std::min(feature, 1.0f));
  }
  return sum / static_cast<double>(std::max<size_t>(a.lab.size(), 1));
}

absl::StatusOr<ImageError> CompareImages(const ImageRgb8& picture, const ImageRgb8& reference) {
  if (picture.width() != reference.width() || picture.height() != reference.height()) {
    return InvalidArgument("compare: {}x{}, reference {}x{}", picture.width(), picture.height(),
                           reference.width(), reference.height());
  }
  ImageError error;
  double squares = 0, bias = 0;
  constexpr int kBlock = 16;
  for (int y0 = 0; y0 < picture.height(); y0 += kBlock) {
    for (int x0 = 0; x0 < picture.width(); x0 += kBlock) {
      double block[3] = {0, 0, 0};
      int count = 0;
      for (int y = y0; y < std::min(y0 + kBlock, picture.height()); ++y) {
        for (int x = x0; x < std::min(x0 + kBlock, picture.width()); ++x, ++count) {
          for (int c = 0; c < 3; ++c) {
            const int d = picture(x, y, c) - reference(x, y, c);
            squares += d * d;
            bias += d;
            block[c] += d;
          }
        }
      }
      for (const double sum : block) {
        error.worst_block = std::max(error.worst_block, std::abs(sum) / count);
      }
    }
  }
  const auto n = static_cast<double>(picture.values().size());
  error.bias = bias / n;
  error.psnr_db = squares > 0 ? 10 * std::log10(255.0 * 255.0 * n / squares)
                              : std::numeric_limits<double>::infinity();
  error.flip = MeanFlip(picture, reference);
  return error;
}

ImageRgb8 SideBySide(const ImageRgb8& left, const ImageRgb8& right) {
  const int w = left.width(), h = left.height();
  ImageRgb8 out(w + right.width(), h);
  for (int y = 0; y < h; ++y) {
    std::copy_n(left.At(0, y), 3 * w, out.At(0, y));
    std::copy_n(right.At(0, y), 3 * right.width(), out.At(w, y));
  }
  return out;
}

ImageRgb8 DifferenceImage(const ImageRgb8& picture, const ImageRgb8& reference, int gain) {
  ImageRgb8 out(picture.width(), picture.height());
  for (size_t i = 0; i < out.values().size(); ++i) {
    const int d = picture.values()[i] - reference.values()[i];
    out.values()[i] = static_cast<uint8_t>(std::min(255, gain * std::abs(d)));
  }
  return out;
}

}  // namespace parallax::bench
