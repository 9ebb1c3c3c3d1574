#include "worker/train/network/optimiser.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace parallax {
namespace {

using torch::Tensor;

constexpr double kBeta1 = 0.9, kBeta2 = 0.999, kEpsilon = 1e-8;

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
  state_.weights.addcdiv_(state_.mean, scale, -rate / (1 - std::pow(kBeta1, count)));
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
