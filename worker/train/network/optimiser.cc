#include "worker/train/network/optimiser.h"

#include <ATen/ops/mkldnn_convolution.h>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace parallax {
namespace {

using torch::Tensor;

constexpr double kBeta1 = 0.9, kBeta2 = 0.999, kEpsilon = 1e-8;
// Muon's learning rate against AdamW's: the length of the steps of a matrix. Matrices of fewer
// outputs are left to AdamW.
constexpr double kMatrixRate = 40;
constexpr int64_t kFewestRows = 8;

// Products of matrices as convolutions of one pixel, which oneDNN computes; torch's own would be
// those of the reference BLAS. `columns` is (1, inner, 1, columns).
Tensor Product(const Tensor& a, const Tensor& columns) {
  return at::mkldnn_convolution(columns, a.unsqueeze(2).unsqueeze(3), {}, {0, 0}, {1, 1}, {1, 1}, 1)
      .view({a.size(0), columns.size(3)});
}

// a b for contiguous matrices.
Tensor Times(const Tensor& a, const Tensor& b) { return Product(a, b.unsqueeze(0).unsqueeze(2)); }

// a a' for a contiguous matrix, whose transpose is its own memory with channels last.
Tensor TimesTransposed(const Tensor& a) {
  return Product(a, a.view({1, 1, a.size(0), a.size(1)}).permute({0, 3, 1, 2}));
}

}  // namespace

Optimiser::Optimiser(torch::nn::Module& network) {
  std::vector<Tensor> parts;
  for (const Tensor& weight : network.parameters()) parts.push_back(weight.detach().reshape(-1));
  state_.weights = torch::cat(parts).clone();
  state_.average = state_.weights.clone();
  state_.mean = torch::zeros_like(state_.weights);
  state_.square = torch::zeros_like(state_.weights);
  gradients_ = torch::zeros_like(state_.weights);
  int64_t at = 0;
  for (Tensor& weight : network.parameters()) {
    if (weight.dim() > 1 && weight.size(0) >= kFewestRows) {
      matrices_.push_back({at, weight.size(0), weight.numel() / weight.size(0)});
    }
    weight.set_data(state_.weights.narrow(0, at, weight.numel()).view(weight.sizes()));
    weight.mutable_grad() = gradients_.narrow(0, at, weight.numel()).view(weight.sizes());
    at += weight.numel();
  }
}

double Optimiser::Step(const TrainSettings& settings, int64_t step) {
  const torch::NoGradGuard no_grad;
  const double norm = gradients_.norm().item<double>();
  if (norm > settings.gradient_clip) gradients_.mul_(settings.gradient_clip / norm);
  const double rate = LearningRate(settings, step);
  const auto count = static_cast<double>(step + 1);
  state_.weights.mul_(1 - rate * settings.weight_decay);
  state_.mean.mul_(kBeta1).add_(gradients_, 1 - kBeta1);
  state_.square.mul_(kBeta2).addcmul_(gradients_, gradients_, 1 - kBeta2);
  const Tensor scale = (state_.square / (1 - std::pow(kBeta2, count))).sqrt_().add_(kEpsilon);
  Tensor update = state_.mean / scale.mul_(1 - std::pow(kBeta1, count));
  for (const Matrix& m : matrices_) {
    const auto of = [&](const Tensor& flat) {
      return flat.narrow(0, m.at, m.rows * m.columns).view({m.rows, m.columns});
    };
    // Nesterov's momentum.
    const Tensor ahead = of(state_.mean) * kBeta1 + of(gradients_) * (1 - kBeta1);
    const double tall = static_cast<double>(m.rows) / static_cast<double>(m.columns);
    of(update).copy_(Orthogonalised(ahead) * (kMatrixRate * std::sqrt(std::max(1.0, tall))));
  }
  state_.weights.add_(update, -rate);
  // Early averages are short, so that the first weights are soon forgotten.
  const double decay = std::min(settings.average_decay, count / (count + 9));
  state_.average.mul_(decay).add_(state_.weights, 1 - decay);
  gradients_.zero_();
  return norm;
}

void Optimiser::Restore(const OptimiserState& state) {
  const torch::NoGradGuard no_grad;
  state_.weights.copy_(state.weights);  // In place: the network's weights are views of it.
  state_.average.copy_(state.average);
  state_.mean.copy_(state.mean);
  state_.square.copy_(state.square);
}

Tensor Orthogonalised(const Tensor& matrix) {
  // Source of the coefficients: Jordan et al., as above.
  constexpr double kLinear = 3.4445, kCubic = -4.7750, kQuintic = 2.0315;
  const bool tall = matrix.size(0) > matrix.size(1);
  Tensor x = (tall ? matrix.t() : matrix).contiguous() / matrix.norm().clamp_min(1e-12);
  for (int i = 0; i < 5; ++i) {
    const Tensor square = TimesTransposed(x);
    Tensor factor = Times(square, square).mul_(kQuintic).add_(square, kCubic);
    factor.diagonal().add_(kLinear);
    x = Times(factor, x);
  }
  return tall ? x.t() : x;
}

void SetWeights(torch::nn::Module& network, const Tensor& flat) {
  const torch::NoGradGuard no_grad;
  int64_t at = 0;
  for (Tensor& weight : network.parameters()) {
    weight.copy_(flat.narrow(0, at, weight.numel()).view(weight.sizes()));
    at += weight.numel();
  }
}

std::string LayoutOf(const torch::nn::Module& network) {
  std::string layout;
  for (const auto& item : network.named_parameters()) {
    layout += item.key();
    for (const int64_t size : item.value().sizes()) layout += fmt::format(" {}", size);
    layout += ";";
  }
  return layout;
}

}  // namespace parallax
