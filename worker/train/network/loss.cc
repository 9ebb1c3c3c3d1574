#include "worker/train/network/loss.h"

#include <torch/nn/functional.h>

namespace parallax {
namespace {

namespace F = torch::nn::functional;
using torch::Tensor;

// Spread of the Laplace distribution about the truth, in candidates (4 px).
constexpr double kSpread = 0.5;
constexpr double kDistributionShare = 0.6, kQuarterShare = 0.2, kHalfShare = 0.3;

// One pixel of each cell: the one nearest to where the features of that cell are centred.
Tensor Every(const Tensor& t, int64_t step) {
  return t.slice(2, step / 4, torch::nullopt, step).slice(3, step / 4, torch::nullopt, step);
}

Tensor WeightedMean(const Tensor& values, const Tensor& weight) {
  return (values * weight).sum() / weight.sum().clamp_min(1.0);
}

Tensor SmoothL1(const Tensor& seen, const Tensor& truth, const Tensor& weight) {
  return WeightedMean(
      F::smooth_l1_loss(seen, truth, F::SmoothL1LossFuncOptions().reduction(torch::kNone)), weight);
}

Tensor CrossEntropy(const Tensor& log_scores, const Tensor& disparity, const Tensor& weight) {
  const Tensor candidates = torch::arange(log_scores.size(1), torch::kFloat).view({1, -1, 1, 1});
  const Tensor target = torch::softmax((candidates - disparity / 4).abs() / -kSpread, 1);
  return WeightedMean(-(target * log_scores).sum(1, true), weight);
}

}  // namespace

BatchLoss LossOf(const StereoOutput& output, const Tensor& disparity, const Tensor& weight) {
  const Tensor quarter_truth = Every(disparity, 4), quarter_weight = Every(weight, 4);
  BatchLoss result;
  result.loss = SmoothL1(output.disparity, disparity, weight) +
                kHalfShare * SmoothL1(output.half, Every(disparity, 2), Every(weight, 2)) +
                kQuarterShare * SmoothL1(output.quarter, quarter_truth, quarter_weight) +
                kDistributionShare * CrossEntropy(output.log_scores, quarter_truth, quarter_weight);
  const torch::NoGradGuard no_grad;
  const Tensor error = (output.disparity - disparity).abs();
  const Tensor visible = (weight == 1).to(torch::kFloat);
  result.epe_px = WeightedMean(error, visible).item<double>();
  result.bad3 = WeightedMean((error > 3).to(torch::kFloat), visible).item<double>();
  return result;
}

}  // namespace parallax
