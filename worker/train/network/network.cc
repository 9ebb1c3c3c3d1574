#include "worker/train/network/network.h"

#include <torch/nn/functional.h>
#include <torch/nn/modules/activation.h>
#include <torch/nn/modules/container/sequential.h>

#include <cmath>
#include <vector>

#include "common/base/rng.h"
#include "worker/train/network/convolution.h"
#include "worker/train/network/correlation.h"

namespace parallax {
namespace {

namespace nn = torch::nn;
namespace F = torch::nn::functional;
using torch::Tensor;

// Channels at 1/2, 1/4, 1/8, 1/16.
constexpr int64_t kHalf = 16, kQuarter = 32, kEighth = 64, kSixteenth = 96;
constexpr int64_t kGroups = 8, kMatch = 48;
// Channels of the hourglass at 1/4, 1/8, 1/16.
constexpr int64_t kCostEighth = 16, kCostSixteenth = 48;
constexpr int64_t kLocalGroups = 2, kLocalRadius = 3, kCorrect = 32;

ConvolutionShape Conv(int64_t in, int64_t out, int64_t kernel, int64_t stride = 1,
                      int64_t dilation = 1) {
  return {in, out, kernel, stride, dilation};
}

ConvolutionShape Conv3(int64_t in, int64_t out, int64_t kernel, int64_t stride = 1) {
  return {in, out, kernel, stride, 1, 3};
}

// A convolution alone.
nn::Sequential Plain(int64_t in, int64_t out, int64_t kernel, bool bias = true) {
  return nn::Sequential(Convolution(ConvolutionShape{in, out, kernel, 1, 1, 2, bias}));
}

Tensor Twice(const Tensor& t) {
  return F::interpolate(t.to(torch::kFloat), F::InterpolateFuncOptions()
                                                 .scale_factor(std::vector<double>(
                                                     static_cast<size_t>(t.dim() - 2), 2.0))
                                                 .mode(torch::kNearest));
}

// Unit length within each of `groups` groups of channels.
Tensor Normalised(const Tensor& t, int64_t groups) {
  const Tensor grouped = t.to(torch::kFloat)
                             .contiguous()
                             .view({t.size(0), groups, t.size(1) / groups, t.size(2), t.size(3)});
  return (grouped * (grouped.square().sum(2, true) + 1e-6).rsqrt()).view(t.sizes());
}

// (batch, channels, candidates, height, width) as (batch * candidates, 3 * channels, height,
// width): each candidate with its two neighbours, so that a 2D convolution sees what a 3D one
// would. For few channels oneDNN's 3D convolution takes twice as long. Channels last, as its 2D
// convolution likes them, and in the convolution's type.
Tensor WithNeighbours(const Tensor& volume) {
  const int64_t candidates = volume.size(2);
  const Tensor last =
      volume.to(ConvolvesInBfloat16() ? torch::kBFloat16 : torch::kFloat).permute({0, 2, 3, 4, 1});
  const Tensor padded = torch::constant_pad_nd(last, {0, 0, 0, 0, 0, 0, 1, 1});
  const auto from = [&](int64_t first) { return padded.slice(1, first, first + candidates); };
  return torch::cat({from(0), from(1), from(2)}, 4).flatten(0, 1).permute({0, 3, 1, 2});
}

// Scales each channel of the volume by what the image shows there.
Tensor Excite(nn::Sequential& guide, const Tensor& features, const Tensor& volume) {
  return volume * torch::sigmoid(guide->forward(features)).unsqueeze(2).to(volume.scalar_type());
}

}  // namespace

StereoNetwork::StereoNetwork() {
  const auto add = [this](const char* name, auto& member, auto value) {
    member = register_module(name, value);
  };
  add("half", half_, Layers(std::vector{Conv(3, kHalf, 3, 2), Conv(kHalf, kHalf, 3)}));
  add("quarter", quarter_,
      Layers(std::vector{Conv(kHalf, kQuarter, 3, 2), Conv(kQuarter, kQuarter, 3),
                         Conv(kQuarter, kQuarter, 3)}));
  add("eighth", eighth_,
      Layers(std::vector{Conv(kQuarter, kEighth, 3, 2), Conv(kEighth, kEighth, 3),
                         Conv(kEighth, kEighth, 3)}));
  add("sixteenth", sixteenth_,
      Layers(std::vector{Conv(kEighth, kSixteenth, 3, 2), Conv(kSixteenth, kSixteenth, 3),
                         Conv(kSixteenth, kSixteenth, 3, 1, 2)}));
  add("lateral_eighth", lateral_eighth_, Layers(std::vector{Conv(kSixteenth, kEighth, 1)}));
  add("up_eighth", up_eighth_, Layers(std::vector{Conv(kEighth, kEighth, 3)}));
  add("lateral_quarter", lateral_quarter_, Layers(std::vector{Conv(kEighth, kQuarter, 1)}));
  add("up_quarter", up_quarter_, Layers(std::vector{Conv(kQuarter, kQuarter, 3)}));
  add("match", match_, Plain(kQuarter, kMatch, 3));

  add("cost_eighth", cost_eighth_,
      Layers(std::vector{Conv3(kGroups, kCostEighth, 3, 2), Conv3(kCostEighth, kCostEighth, 3)}));
  add("cost_sixteenth", cost_sixteenth_,
      Layers(std::vector{Conv3(kCostEighth, kCostSixteenth, 3, 2),
                         Conv3(kCostSixteenth, kCostSixteenth, 3),
                         Conv3(kCostSixteenth, kCostSixteenth, 3)}));
  add("narrow_sixteenth", narrow_sixteenth_,
      Layers(std::vector{Conv3(kCostSixteenth, kCostEighth, 1)}));
  add("merge_eighth", merge_eighth_,
      Layers(std::vector{Conv3(kCostEighth, kCostEighth, 3), Conv3(kCostEighth, kCostEighth, 3)}));
  add("narrow_eighth", narrow_eighth_, Layers(std::vector{Conv3(kCostEighth, kGroups, 1)}));
  add("merge_quarter", merge_quarter_, Plain(3 * kGroups, kGroups, 3));
  merge_quarter_->push_back(nn::ReLU(nn::ReLUOptions(true)));
  add("score", score_, Plain(kGroups, 1, 1, false));
  add("guide_quarter", guide_quarter_, Plain(kQuarter, kGroups, 1));
  add("guide_eighth", guide_eighth_, Plain(kEighth, kCostEighth, 1));
  add("guide_sixteenth", guide_sixteenth_, Plain(kSixteenth, kCostSixteenth, 1));

  add("upsample_half", upsample_half_, Plain(kQuarter, 36, 3));
  const int64_t seen = kLocalGroups * (2 * kLocalRadius + 1) + kHalf + 2;
  add("correct", correct_,
      Layers(std::vector{Conv(seen, kCorrect, 3), Conv(kCorrect, kCorrect, 3, 1, 2),
                         Conv(kCorrect, kCorrect, 3)}));
  add("correction", correction_, Plain(kCorrect, 1, 3));
  add("upsample_full", upsample_full_, Plain(kCorrect, 36, 3));
}

StereoNetwork::Features StereoNetwork::Describe(const Tensor& images) {
  Features f;
  f.half = half_->forward((images * 2 - 1).contiguous(torch::MemoryFormat::ChannelsLast));
  const Tensor quarter = quarter_->forward(f.half);
  const Tensor eighth = eighth_->forward(quarter);
  f.sixteenth = sixteenth_->forward(eighth);
  f.eighth = up_eighth_->forward(eighth + Twice(lateral_eighth_->forward(f.sixteenth)));
  f.quarter = up_quarter_->forward(quarter + Twice(lateral_quarter_->forward(f.eighth)));
  f.match = Normalised(match_->forward(f.quarter), kGroups);
  return f;
}

Tensor StereoNetwork::Aggregate(const Tensor& volume, const Features& left) {
  const Tensor eighth = Excite(guide_eighth_, left.eighth, cost_eighth_->forward(volume));
  const Tensor sixteenth =
      Excite(guide_sixteenth_, left.sixteenth, cost_sixteenth_->forward(eighth));
  const Tensor up_eighth =
      merge_eighth_->forward(eighth + Twice(narrow_sixteenth_->forward(sixteenth)));
  const Tensor context = Twice(narrow_eighth_->forward(up_eighth));
  const Tensor up_quarter = Excite(guide_quarter_, left.quarter, volume) + context;
  const Tensor scores = score_->forward(merge_quarter_->forward(WithNeighbours(up_quarter)));
  return scores.reshape({volume.size(0), volume.size(2), volume.size(3), volume.size(4)});
}

StereoOutput StereoNetwork::Forward(const Tensor& left_image, const Tensor& right_image,
                                    int64_t max_disparity) {
  const Features both = Describe(torch::cat({left_image, right_image}));
  const auto first = [](const Tensor& t) { return t.narrow(0, 0, t.size(0) / 2); };
  const std::vector<Tensor> match = both.match.chunk(2);
  const Features left{first(both.half), first(both.quarter), first(both.eighth),
                      first(both.sixteenth), match[0]};

  // All disparities at 1/4. The volume's depth is padded so that it halves twice.
  const int64_t candidates = (max_disparity / 4 + 3) / 4 * 4;
  const Tensor volume = (plain_ ? PlainCorrelationVolume : CorrelationVolume)(match[0], match[1],
                                                                              kGroups, candidates);
  StereoOutput out;
  out.log_scores = torch::log_softmax(Aggregate(volume, left), 1);
  const Tensor quarter = ModeDisparity(out.log_scores);
  out.quarter = quarter * 4;

  // Correction at 1/2.
  const Tensor half = ConvexUpsample(quarter * 2, upsample_half_->forward(left.quarter));
  out.half = half * 2;
  const Tensor start = half.detach();
  const std::vector<Tensor> features = Normalised(both.half, kLocalGroups).chunk(2);
  const Tensor local = (plain_ ? PlainLocalCorrelation : LocalCorrelation)(
      features[0], features[1], start, kLocalGroups, kLocalRadius);
  const Tensor relief =
      start - F::avg_pool2d(
                  start, F::AvgPool2dFuncOptions(9).stride(1).padding(4).count_include_pad(false));
  const Tensor peak = Twice(std::get<0>(out.log_scores.detach().max(1, true)).exp());
  const Tensor corrected =
      correct_->forward(torch::cat({local, left.half, relief.clamp(-8, 8), peak}, 1));
  const Tensor fine = torch::relu(half + correction_->forward(corrected));
  out.disparity = ConvexUpsample(fine * 2, upsample_full_->forward(corrected));
  return out;
}

void InitialiseWeights(StereoNetwork& network, uint64_t seed) {
  const torch::NoGradGuard no_grad;
  for (auto& item : network.named_parameters()) {
    Tensor& weight = item.value();
    if (weight.dim() < 2) continue;  // Normalisation and biases.
    Rng rng = Rng(SceneSeed{seed}, "weights").Child(item.key());
    const double fan_in = static_cast<double>(weight.numel() / weight.size(0));
    float* values = weight.data_ptr<float>();
    for (int64_t i = 0; i < weight.numel(); ++i)
      values[i] = static_cast<float>(rng.Normal(0, std::sqrt(2.0 / fan_in)));
  }
  for (auto& item : network.named_parameters()) {
    if (item.key().ends_with("bias")) item.value().zero_();
  }
}

Tensor ConvexUpsample(const Tensor& coarse, const Tensor& weights) {
  const int64_t n = coarse.size(0), h = coarse.size(2), w = coarse.size(3);
  const Tensor mask =
      torch::softmax(weights.to(torch::kFloat).contiguous().view({n, 4, 9, h, w}), 2);
  const Tensor padded = F::pad(coarse, F::PadFuncOptions({1, 1, 1, 1}).mode(torch::kReplicate));
  const Tensor around = F::unfold(padded, F::UnfoldFuncOptions(3)).view({n, 1, 9, h, w});
  return F::pixel_shuffle((mask * around).sum(2), F::PixelShuffleFuncOptions(2));
}

Tensor ModeDisparity(const Tensor& log_scores) {
  const Tensor best = std::get<1>(log_scores.detach().max(1, true));
  const Tensor offsets = torch::arange(-2, 3).view({1, 5, 1, 1});
  const Tensor candidates = best + offsets;
  const Tensor inside = (candidates >= 0) & (candidates < log_scores.size(1));
  const Tensor scores = log_scores.gather(1, candidates.clamp(0, log_scores.size(1) - 1));
  const Tensor shares = torch::softmax(scores.masked_fill(~inside, -1e9), 1);
  return (shares * candidates.to(torch::kFloat)).sum(1, true);
}

}  // namespace parallax
