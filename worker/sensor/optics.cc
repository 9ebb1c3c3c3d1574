#include "worker/sensor/optics.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace parallax {
namespace {

constexpr double kWidest_px = 64;
constexpr double kStep = 1.5;  // From one width of blur to the next: between two, they are mixed.

cv::Mat MatOf(ImageF3& image) {
  return cv::Mat(image.height(), image.width(), CV_32FC3, image.data());
}

// A disk of this diameter, in pixels; the rim's pixels weigh as much as of them is covered.
cv::Mat Disk(double diameter_px) {
  constexpr int kParts = 8;
  const double radius = 0.5 * diameter_px;
  const int reach = std::max(0, static_cast<int>(std::ceil(radius - 0.5)));
  cv::Mat kernel(2 * reach + 1, 2 * reach + 1, CV_32F);
  double sum = 0;
  for (int y = -reach; y <= reach; ++y) {
    for (int x = -reach; x <= reach; ++x) {
      int covered = 0;
      for (int part = 0; part < kParts * kParts; ++part) {
        const double u = x + (part % kParts + 0.5) / kParts - 0.5;
        const double v = y + (part / kParts + 0.5) / kParts - 0.5;
        covered += u * u + v * v <= radius * radius ? 1 : 0;
      }
      kernel.at<float>(y + reach, x + reach) = static_cast<float>(covered);
      sum += covered;
    }
  }
  return kernel / sum;
}

// The discrete counterpart of a Gaussian: its variance is exactly sigma^2, however narrow it is.
//   Source: Lindeberg, "Scale-space for discrete signals", PAMI 1990: T(n, t) = exp(-t) I_n(t).
cv::Mat GaussianKernel(double sigma_px) {
  const double t = sigma_px * sigma_px;
  const int reach = static_cast<int>(std::ceil(5 * sigma_px)) + 1;
  cv::Mat kernel(1, 2 * reach + 1, CV_32F);
  for (int n = -reach; n <= reach; ++n) {
    const double weight = std::exp(-t) * std::cyl_bessel_i(std::abs(n), t);
    kernel.at<float>(0, n + reach) = static_cast<float>(weight);
  }
  return kernel;
}

// Widths of blur, from none to the first that is as wide as `widest`.
std::vector<double> WidthsUpTo(double widest) {
  std::vector<double> widths = {1};  // A disk of one pixel blurs nothing.
  while (widths.back() < widest) widths.push_back(widths.back() * kStep);
  return widths;
}

}  // namespace

void SpreadPoints(double sigma_px, ImageF3& picture) {
  if (!(sigma_px > 0)) return;
  cv::Mat view = MatOf(picture);
  const cv::Mat kernel = GaussianKernel(sigma_px);
  cv::sepFilter2D(view, view, -1, kernel, kernel, {-1, -1}, 0, cv::BORDER_REFLECT_101);
}

double CircleOfConfusion(double defocus_px, double focus_m, double depth_m) {
  return depth_m > 0 ? defocus_px * std::abs(1 - focus_m / depth_m) : defocus_px;
}

void Defocus(double defocus_px, double focus_m, const ImageF& depth_m, ImageF3& picture) {
  if (!(defocus_px > 0)) return;
  ImageF width_px(picture.width(), picture.height());
  double widest = 0;
  for (size_t i = 0; i < width_px.values().size(); ++i) {
    const double circle = CircleOfConfusion(defocus_px, focus_m, double{depth_m.values()[i]});
    width_px.values()[i] = static_cast<float>(std::clamp(circle, 1.0, kWidest_px));
    widest = std::max(widest, double{width_px.values()[i]});
  }
  const std::vector<double> widths = WidthsUpTo(widest);
  std::vector<ImageF3> blurred(widths.size(), picture);
  tbb::parallel_for(size_t{1}, widths.size(), [&](size_t i) {
    cv::Mat view = MatOf(blurred[i]);
    cv::filter2D(MatOf(blurred[0]), view, -1, Disk(widths[i]), {-1, -1}, 0, cv::BORDER_REFLECT_101);
  });
  for (size_t i = 0; i < width_px.values().size(); ++i) {
    const double at = std::log(double{width_px.values()[i]}) / std::log(kStep);
    const size_t low = std::min(static_cast<size_t>(at), widths.size() - 1);
    const size_t high = std::min(low + 1, widths.size() - 1);
    const auto t = static_cast<float>(at - static_cast<double>(low));
    for (size_t c = 3 * i; c < 3 * i + 3; ++c) {
      const float a = blurred[low].values()[c], b = blurred[high].values()[c];
      picture.values()[c] = a + (b - a) * t;
    }
  }
}

void Vignette(double vignetting, ImageF3& picture) {
  if (!(vignetting > 0)) return;
  const double k = 1 / std::sqrt(1 - vignetting) - 1;
  const double middle_x = 0.5 * picture.width(), middle_y = 0.5 * picture.height();
  const double corner2 = middle_x * middle_x + middle_y * middle_y;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const double dx = x + 0.5 - middle_x, dy = y + 0.5 - middle_y;
      const double fall = 1 + k * (dx * dx + dy * dy) / corner2;
      const auto kept = static_cast<float>(1 / (fall * fall));
      for (int c = 0; c < 3; ++c) picture(x, y, c) *= kept;
    }
  }
}

}  // namespace parallax
