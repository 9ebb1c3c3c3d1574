#include "worker/train/trained_predictor.h"

#include <ATen/Parallel.h>
#include <torch/nn/functional.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "worker/train/hidden_pixels.h"
#include "worker/train/network/checkpoint.h"

namespace parallax {
namespace {

namespace F = torch::nn::functional;
using torch::Tensor;

// The nearest things decide how far a pair may be enlarged: this part of the first disparities is
// not larger than theirs, and the search goes somewhat beyond them.
constexpr double kNearestShare = 0.995, kDisparityMargin = 1.1;
// The first look counts where this part of its certainty is more than that of the second one. Both
// are averaged around the pixel by a Gaussian. The first is surer by nature: its candidates are
// larger.
constexpr float kSurer = 0.6f;
constexpr double kAround_px = 5;

int RoundUp(double value, int multiple) {
  return static_cast<int>(std::ceil(value / multiple - 1e-9)) * multiple;
}

// (1, 3, padded height, padded width) in [0, 1]; the last row and column are repeated.
Tensor ToTensor(const ImageRgb8& image, const NetworkSize& size) {
  cv::Mat pixels(image.height(), image.width(), CV_8UC3, const_cast<uint8_t*>(image.data()));
  if (size.width != image.width() || size.height != image.height()) {
    const bool larger = size.width > image.width();
    cv::resize(pixels, pixels, cv::Size(size.width, size.height), 0, 0,
               larger ? cv::INTER_CUBIC : cv::INTER_AREA);
  }
  const Tensor bytes = torch::from_blob(pixels.data, {size.height, size.width, 3}, torch::kByte);
  const Tensor planes = bytes.permute({2, 0, 1}).to(torch::kFloat).div(255).unsqueeze(0);
  return F::pad(planes, F::PadFuncOptions({0, size.padded_width - size.width, 0,
                                           size.padded_height - size.height})
                            .mode(torch::kReplicate));
}

// OpenCV's view of a picture.
cv::Mat MatOf(const ImageF& image) {
  return {image.height(), image.width(), CV_32F, const_cast<float*>(image.data())};
}

// The upper left `width` x `height` values of a plane (1, 1, height, width), on the pixels of the
// input.
ImageF OnInput(const Tensor& plane, int width, int height, const ImageRgb8& input) {
  const Tensor used = plane.slice(2, 0, height).slice(3, 0, width).contiguous();
  ImageF image(input.width(), input.height());
  cv::Mat to = MatOf(image);
  cv::resize(cv::Mat(height, width, CV_32F, used.data_ptr<float>()), to, to.size(), 0, 0,
             cv::INTER_LINEAR);
  return image;
}

// (1, 1, height / 4, width / 4): see struct Look.
Tensor Certainty(const Tensor& log_scores) {
  const auto three = F::AvgPool3dFuncOptions({3, 1, 1}).stride({1, 1, 1}).padding({1, 0, 0});
  return 3 * std::get<0>(F::avg_pool3d(log_scores.exp().unsqueeze(1), three).max(2));
}

// The name of the first weight that has a value that is not finite; empty if none exists.
std::string FirstNotFinite(const StereoNetwork& network) {
  for (const auto& weight : network.named_parameters()) {
    if (!at::isfinite(weight.value()).all().item<bool>()) return weight.key();
  }
  return "";
}

NetworkSize SizeAt(int width, int height, double scale, double max_disparity) {
  NetworkSize size;
  size.width = std::max(1, static_cast<int>(std::lround(width * scale)));
  size.height = std::max(1, static_cast<int>(std::lround(height * scale)));
  size.padded_width = RoundUp(size.width, static_cast<int>(kSizeMultiple));
  size.padded_height = RoundUp(size.height, static_cast<int>(kSizeMultiple));
  size.max_disparity = std::clamp(RoundUp(max_disparity, 16), 32, kNetworkDisparity);
  return size;
}

}  // namespace

NetworkSize ChooseNetworkSize(int width, int height, int trained_disparity, double max_disparity,
                              double reduction) {
  double scale = std::min(1.0, static_cast<double>(kNetworkWidth) / width);
  if (max_disparity > 0) scale = std::min(scale, kNetworkDisparity / max_disparity);
  scale *= reduction;
  return SizeAt(width, height, scale,
                max_disparity > 0 ? max_disparity * scale : trained_disparity);
}

double ChooseEnlargement(const ImageF& disparity_px, int trained_disparity) {
  std::vector<float> seen(disparity_px.values().begin(), disparity_px.values().end());
  const auto far =
      seen.begin() + static_cast<int64_t>(kNearestShare * static_cast<double>(seen.size()));
  std::nth_element(seen.begin(), far, seen.end());
  const double room = trained_disparity / std::max(1.0, kDisparityMargin * *far);
  return std::min({kMostEnlarged, static_cast<double>(kNetworkWidth) / disparity_px.width(), room});
}

ImageF JoinLooks(const Look& coarse, const Look& fine) {
  const auto around = [](const ImageF& certainty) {
    ImageF mean(certainty.width(), certainty.height());
    cv::Mat to = MatOf(mean);
    cv::GaussianBlur(MatOf(certainty), to, cv::Size(), kAround_px, kAround_px);
    return mean;
  };
  const ImageF first = around(coarse.certainty), second = around(fine.certainty);
  ImageF joined = fine.disparity_px;
  for (size_t i = 0; i < joined.values().size(); ++i) {
    if (kSurer * first.values()[i] > second.values()[i]) {
      joined.values()[i] = coarse.disparity_px.values()[i];
    }
  }
  return joined;
}

struct Predictor::State {
  std::shared_ptr<StereoNetwork> network = std::make_shared<StereoNetwork>();
  int trained_disparity = 192;
  bool one_scale = false;  // It was trained at one scale, and is not shown another.

  // One look or, where it pays, two. Disparities are in pixels of the input.
  absl::StatusOr<ImageF> Disparities(const ImageRgb8& left, const ImageRgb8& right,
                                     const PredictOptions& options) const;
  // One look at this size.
  absl::StatusOr<Look> LookAt(const ImageRgb8& left, const ImageRgb8& right,
                              const NetworkSize& size) const;
};

absl::StatusOr<Look> Predictor::State::LookAt(const ImageRgb8& left, const ImageRgb8& right,
                                              const NetworkSize& size) const {
  const torch::NoGradGuard no_grad;
  StereoOutput output;
  try {
    output = network->Forward(ToTensor(left, size), ToTensor(right, size), size.max_disparity);
    Look look{
        OnInput(output.disparity, size.width, size.height, left),
        OnInput(Certainty(output.log_scores), (size.width + 3) / 4, (size.height + 3) / 4, left)};
    const double scale = static_cast<double>(left.width()) / size.width;
    for (int y = 0; y < left.height(); ++y) {
      for (int x = 0; x < left.width(); ++x) {
        float& disparity_px = look.disparity_px(x, y);
        if (!std::isfinite(disparity_px)) {
          return Internal("the network's disparity at pixel ({}, {}) is not finite", x, y);
        }
        disparity_px = static_cast<float>(std::max(0.0, scale * disparity_px));
      }
    }
    return look;
  } catch (const std::exception& error) {
    const std::string text = error.what();
    return ResourceExhausted("{}", text.substr(0, text.find('\n')));
  }
}

absl::StatusOr<ImageF> Predictor::State::Disparities(const ImageRgb8& left, const ImageRgb8& right,
                                                     const PredictOptions& options) const {
  const int width = left.width(), height = left.height();
  const bool twice = options.looks >= 2 && !one_scale;
  const NetworkSize size = ChooseNetworkSize(width, height, trained_disparity,
                                             options.max_disparity, twice ? kFirstLook : 1);
  ASSIGN_OR_RETURN(Look first, LookAt(left, right, size));
  if (!twice) return std::move(first.disparity_px);
  const double scale = ChooseEnlargement(first.disparity_px, trained_disparity);
  if (scale * width < kLeastEnlarged * size.width) return std::move(first.disparity_px);
  const double search =
      options.max_disparity > 0 ? options.max_disparity * scale : trained_disparity;
  ASSIGN_OR_RETURN(const Look second, LookAt(left, right, SizeAt(width, height, scale, search)));
  return JoinLooks(first, second);
}

Predictor::Predictor(std::unique_ptr<State> state) : state_(std::move(state)) {}
Predictor::Predictor(Predictor&&) noexcept = default;
Predictor::~Predictor() = default;

absl::StatusOr<Predictor> Predictor::Load(const std::string& path) {
  auto state = std::make_unique<State>();
  ASSIGN_OR_RETURN(const Checkpoint checkpoint, ReadCheckpoint(path, *state->network));
  SetWeights(*state->network, checkpoint.state.average);
  if (const std::string name = FirstNotFinite(*state->network); !name.empty()) {
    return DataLoss("{}: weight {} is not finite: its training has diverged", path, name);
  }
  state->trained_disparity = checkpoint.settings.value("max_disparity", 192);
  state->one_scale = checkpoint.settings.value("scale_high", 0.0) <= 0;
  return Predictor(std::move(state));
}

absl::StatusOr<ImageF> Predictor::Predict(const ImageRgb8& left, const ImageRgb8& right,
                                          const PredictOptions& options) const {
  if (left.empty() || left.width() != right.width() || left.height() != right.height()) {
    return InvalidArgument("the left image is {}x{} px, the right {}x{}", left.width(),
                           left.height(), right.width(), right.height());
  }
  if (options.threads > 0) at::set_num_threads(options.threads);
  ASSIGN_OR_RETURN(ImageF disparity, state_->Disparities(left, right, options));
  return FillHiddenPixels(std::move(disparity));
}

}  // namespace parallax
