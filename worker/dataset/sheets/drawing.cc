#include "worker/dataset/sheets/drawing.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace parallax {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kCapital = 21.0;  // Height of a capital of the font at scale 1.
constexpr int kFine = 4;  // Text is drawn this much larger and averaged down: smooth thin strokes.

cv::Mat MatOf(ImageRgb8& image) {
  return cv::Mat(image.height(), image.width(), CV_8UC3, image.data());
}

std::string Ascii(std::string_view text) {
  std::string ascii(text);
  for (char& c : ascii) {
    if (c < 0x20 || c > 0x7e) c = '?';
  }
  return ascii;
}

}  // namespace

void Canvas::FillBox(int x, int y, int width, int height, const Rgb& color) {
  for (int row = std::max(y, 0); row < std::min(y + height, image_.height()); ++row) {
    for (int column = std::max(x, 0); column < std::min(x + width, image_.width()); ++column) {
      std::copy(color.begin(), color.end(), image_.At(column, row));
    }
  }
}

void Canvas::DrawImage(int x, int y, int width, int height, const ImageRgb8& image, bool exact) {
  if (image.empty() || width <= 0 || height <= 0) return;
  const cv::Rect place =
      cv::Rect(x, y, width, height) & cv::Rect(0, 0, image_.width(), image_.height());
  if (place.empty()) return;
  cv::Mat scaled;
  cv::resize(MatOf(const_cast<ImageRgb8&>(image)), scaled, cv::Size(width, height), 0, 0,
             exact ? cv::INTER_NEAREST : cv::INTER_AREA);
  cv::Mat target = MatOf(image_);
  scaled(place - cv::Point(x, y)).copyTo(target(place));
}

void Canvas::DrawText(int x, int y, std::string_view text, double size_px, const Rgb& color,
                      bool bold) {
  const std::string ascii = Ascii(text);
  const double scale = kFine * size_px / kCapital;
  const int thickness =
      std::max(1, static_cast<int>(std::lround(kFine * size_px * (bold ? 0.2 : 0.125))));
  const int width = TextWidth(text, size_px) + 4, height = static_cast<int>(2 * size_px) + 4;
  if (ascii.empty()) return;
  cv::Mat mask = cv::Mat::zeros(height * kFine, width * kFine, CV_8U);
  const int baseline = static_cast<int>(1.4 * size_px);
  cv::putText(mask, ascii, cv::Point(kFine, baseline * kFine), kFont, scale, cv::Scalar(255),
              thickness, cv::LINE_AA);
  cv::Mat small;
  cv::resize(mask, small, cv::Size(width, height), 0, 0, cv::INTER_AREA);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const int px = x + column, py = y - baseline + row;
      if (px < 0 || py < 0 || px >= image_.width() || py >= image_.height()) continue;
      const int alpha = small.at<uint8_t>(row, column);
      for (int c = 0; c < 3; ++c) {
        uint8_t& value = image_(px, py, c);
        value = static_cast<uint8_t>(
            (value * (255 - alpha) + color[static_cast<size_t>(c)] * alpha) / 255);
      }
    }
  }
}

int Canvas::TextWidth(std::string_view text, double size_px) {
  int baseline = 0;
  const cv::Size size =
      cv::getTextSize(Ascii(text), kFont, kFine * size_px / kCapital, 1, &baseline);
  return (size.width + kFine - 1) / kFine;
}

std::string FitText(std::string text, double size_px, int width) {
  if (Canvas::TextWidth(text, size_px) <= width) return text;
  while (!text.empty() && Canvas::TextWidth(text + "..", size_px) > width) text.pop_back();
  return text + "..";
}

Rgb Turbo(double value) {
  static const std::array<Rgb, 256> table = [] {
    cv::Mat ramp(1, 256, CV_8U), colors;
    for (int i = 0; i < 256; ++i) ramp.at<uint8_t>(0, i) = static_cast<uint8_t>(i);
    cv::applyColorMap(ramp, colors, cv::COLORMAP_TURBO);
    std::array<Rgb, 256> all;
    for (int i = 0; i < 256; ++i) {
      const cv::Vec3b bgr = colors.at<cv::Vec3b>(0, i);
      all[static_cast<size_t>(i)] = {bgr[2], bgr[1], bgr[0]};
    }
    return all;
  }();
  return table[static_cast<size_t>(std::lround(255 * std::clamp(value, 0.0, 1.0)))];
}

Rgb IndexColor(uint32_t index) {
  if (index == 0) return {0, 0, 0};
  // Steps of the golden ratio spread hues; brightness and saturation change with other periods.
  const double hue = std::fmod(0.11 + index * 0.6180339887498949, 1.0) * 6;
  const double saturation = 0.45 + 0.2 * (index % 3),
               value = 0.65 + 0.175 * (index % 3 == 0 ? 2 : index % 2);
  Rgb color;
  for (int c = 0; c < 3; ++c) {
    const double k = std::fmod(5.0 - 2 * c + hue, 6.0);
    const double level = value - value * saturation * std::clamp(std::min(k, 4 - k), 0.0, 1.0);
    color[static_cast<size_t>(c)] = static_cast<uint8_t>(std::lround(255 * level));
  }
  return color;
}

int TileHeight(int tile_width_px, int width, int height) {
  return std::max(
      1, static_cast<int>(std::lround(double(tile_width_px) * height / std::max(width, 1))));
}

std::vector<size_t> Spread(size_t count, int most) {
  const size_t chosen = std::min(count, static_cast<size_t>(std::max(most, 1)));
  std::vector<size_t> indices;
  for (size_t i = 0; i < chosen; ++i) {
    indices.push_back(chosen == 1 ? 0 : i * (count - 1) / (chosen - 1));
  }
  return indices;
}

double ColorScale(const ImageF& disparity_px, int part) {
  std::vector<float> known;
  for (const float value : disparity_px.values()) {
    if (std::isfinite(value) && value > 0) known.push_back(value);
  }
  if (known.empty()) return 1;
  const auto near = known.end() - 1 - static_cast<std::ptrdiff_t>(known.size()) / part;
  std::nth_element(known.begin(), near, known.end());
  return *near;
}

ImageRgb8 ColorDisparity(const ImageF& disparity_px, double full_scale_px) {
  return Colored(disparity_px, [&](const float* disparity) {
    if (*disparity <= 0) return Rgb{};
    return Turbo(std::sqrt(*disparity / std::max(full_scale_px, 1e-6)));
  });
}

ImageRgb8 ColorIndices(const ImageU16& indices) {
  return Colored(indices, [](const uint16_t* index) { return IndexColor(*index); });
}

ImageRgb8 ColorOcclusion(const ImageU8& occlusion) {
  return Colored(occlusion, [](const uint8_t* value) { return Rgb{*value, *value, *value}; });
}

ImageRgb8 ColorNormals(const ImageF3& normals) {
  return Colored(normals, [](const float* n) {
    Rgb color{};
    if (n[0] == 0 && n[1] == 0 && n[2] == 0) return color;
    const float shown[3] = {n[0], -n[1], -n[2]};
    for (size_t c = 0; c < 3; ++c) {
      color[c] =
          static_cast<uint8_t>(std::lround(std::clamp(127.5f + 127.5f * shown[c], 0.0f, 255.0f)));
    }
    return color;
  });
}

}  // namespace parallax
