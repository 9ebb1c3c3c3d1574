#include "worker/train/network/exchange_network.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "common/base/system/file.h"
#include "worker/train/network/network_backend.h"

namespace parallax {
namespace {

int RoundUp(int value, int multiple) { return (value + multiple - 1) / multiple * multiple; }

// Writes the picture's channels from `planes` on, scaled to `size` and padded to the planes' size.
void WritePlanes(const ImageRgb8& image, cv::Size size, const NetworkConventions& conventions,
                 cv::Mat& blob, int first) {
  cv::Mat pixels(image.height(), image.width(), CV_8UC3, const_cast<uint8_t*>(image.data()));
  if (pixels.size() != size) {
    const bool larger = size.width > pixels.cols;
    cv::resize(pixels, pixels, size, 0, 0, larger ? cv::INTER_CUBIC : cv::INTER_AREA);
  }
  const int height = blob.size[2], width = blob.size[3];
  for (int c = 0; c < 3; ++c) {
    const size_t channel = static_cast<size_t>(c);
    const double scale = conventions.pixel_range / 255 / conventions.std[channel];
    const double shift = -conventions.mean[channel] / conventions.std[channel];
    cv::Mat plane, values;
    cv::extractChannel(pixels, plane, conventions.bgr ? 2 - c : c);
    plane.convertTo(values, CV_32F, scale, shift);
    cv::Mat target(height, width, CV_32F, blob.ptr<float>(0, first + c));
    cv::copyMakeBorder(values, target, 0, height - size.height, 0, width - size.width,
                       cv::BORDER_REPLICATE);
  }
}

// The pictures as the network's one or two inputs.
std::vector<cv::Mat> MakeInputs(const ImageRgb8& left, const ImageRgb8& right, cv::Size size,
                                cv::Size padded, int inputs,
                                const NetworkConventions& conventions) {
  const std::vector<int> shape = {1, 6 / inputs, padded.height, padded.width};
  std::vector<cv::Mat> blobs;
  for (int i = 0; i < inputs; ++i) blobs.emplace_back(shape, CV_32F);
  WritePlanes(left, size, conventions, blobs.front(), 0);
  WritePlanes(right, size, conventions, blobs.back(), inputs == 1 ? 3 : 0);
  return blobs;
}

std::string ShapeText(const std::vector<int64_t>& shape) {
  std::string text;
  for (const int64_t size : shape) text += (text.empty() ? "" : ", ") + std::to_string(size);
  return "(" + text + ")";
}

// The first channel of the output. Errors: kInvalidArgument if it is not of the size `padded`.
absl::StatusOr<cv::Mat> FirstChannel(NetworkOutput& output, cv::Size padded) {
  const std::vector<int64_t>& shape = output.shape;
  const size_t count = shape.size();
  const bool good = count >= 2 && count <= 4 && shape[count - 1] == padded.width &&
                    shape[count - 2] == padded.height && (count < 4 || shape[0] == 1);
  if (!good) {
    return InvalidArgument(
        "the network's output has the shape {}, but must be disparities of the {}x{} px that it "
        "was "
        "given (other outputs: output)",
        ShapeText(shape), padded.width, padded.height);
  }
  return cv::Mat(padded, CV_32F, output.values.data());
}

// Which picture an input's name asks for: 'l' for "left", "img_L", 'r' for "right_image", "imgR"; 0
// for other names.
char EyeOf(const std::string& name) {
  std::string lower = name;
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const bool left = lower.find("left") != lower.npos, right = lower.find("right") != lower.npos;
  if (left != right) return left ? 'l' : 'r';
  if (name.ends_with('L') || lower.ends_with("_l") || lower == "l") return 'l';
  if (name.ends_with('R') || lower.ends_with("_r") || lower == "r") return 'r';
  return 0;
}

}  // namespace

bool RightComesFirst(const std::string& first, const std::string& second) {
  const char one = EyeOf(first), two = EyeOf(second);
  return one != two && (one == 'r' || two == 'l');
}

absl::StatusOr<size_t> OutputNumber(int output, size_t count) {
  const int64_t number = output < 0 ? static_cast<int64_t>(count) + output : output;
  if (number >= 0 && number < static_cast<int64_t>(count)) return static_cast<size_t>(number);
  return InvalidArgument("the network has {} outputs, but the output is number {}", count, output);
}

ExchangeNetwork::ExchangeNetwork(std::unique_ptr<NetworkBackend> backend,
                                 const NetworkConventions& conventions)
    : backend_(std::move(backend)), conventions_(conventions) {}
ExchangeNetwork::ExchangeNetwork(ExchangeNetwork&&) noexcept = default;
ExchangeNetwork::~ExchangeNetwork() = default;

absl::StatusOr<ExchangeNetwork> ExchangeNetwork::Load(const std::string& path,
                                                      ExchangeFormat format,
                                                      const NetworkConventions& conventions,
                                                      int threads) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  const auto load = format == ExchangeFormat::kOnnx ? LoadOnnx : LoadTorchScript;
  ASSIGN_OR_RETURN(auto backend, load(bytes, path, threads));
  const cv::Size wanted(conventions.width_px, conventions.height_px), told = backend->size();
  if (wanted != cv::Size() && wanted.empty()) {
    return InvalidArgument("the network's size is {}x{} px, but must be at least 1x1", wanted.width,
                           wanted.height);
  }
  if (wanted != cv::Size() && !told.empty() && wanted != told) {
    return InvalidArgument("{}: takes pictures of {}x{} px, but the size is {}x{}", path,
                           told.width, told.height, wanted.width, wanted.height);
  }
  return ExchangeNetwork(std::move(backend), conventions);
}

absl::StatusOr<ImageF> ExchangeNetwork::Predict(const ImageRgb8& left, const ImageRgb8& right) {
  if (left.empty() || left.width() != right.width() || left.height() != right.height()) {
    return InvalidArgument("the left image is {}x{} px, the right {}x{}", left.width(),
                           left.height(), right.width(), right.height());
  }
  cv::Size size = backend_->size();
  if (size.empty()) size = {conventions_.width_px, conventions_.height_px};
  const bool fixed = !size.empty();
  if (!fixed) size = {left.width(), left.height()};
  const int multiple = fixed ? 1 : conventions_.pad_multiple;
  const cv::Size padded(RoundUp(size.width, multiple), RoundUp(size.height, multiple));
  ASSIGN_OR_RETURN(NetworkOutput output, backend_->Run(MakeInputs(left, right, size, padded,
                                                                  backend_->inputs(), conventions_),
                                                       conventions_.output));
  ASSIGN_OR_RETURN(const cv::Mat seen, FirstChannel(output, padded));
  cv::Mat full;
  cv::resize(seen(cv::Rect({0, 0}, size)), full, cv::Size(left.width(), left.height()), 0, 0,
             cv::INTER_LINEAR);
  const double scale =
      (conventions_.negate ? -1.0 : 1.0) * static_cast<double>(left.width()) / size.width;
  ImageF disparity(left.width(), left.height());
  for (int y = 0; y < left.height(); ++y) {
    for (int x = 0; x < left.width(); ++x) {
      const double value = scale * full.at<float>(y, x);
      if (!std::isfinite(value)) {
        return Internal("the network's disparity at pixel ({}, {}) is not finite", x, y);
      }
      disparity(x, y) = static_cast<float>(std::max(0.0, value));
    }
  }
  return disparity;
}

}  // namespace parallax
