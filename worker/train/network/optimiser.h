// AdamW over one flat vector of all weights, with a moving average of the weights beside it. The
// vector is flat, so that a checkpoint is four vectors and equal runs write equal bytes.
//   Source: Loshchilov and Hutter, "Decoupled Weight Decay Regularization", ICLR 2019.
#pragma once

#include <torch/nn/module.h>
#include <torch/types.h>

#include <string>

#include "worker/train/network/settings.h"

namespace parallax {

// The flat vectors of a checkpoint.
struct OptimiserState {
  torch::Tensor weights, average, mean, square;  // One-dimensional, float32.
};

// The optimiser of one network.
class Optimiser {
 public:
  // Moves the weights and gradients of `network`, which must outlive this, into flat vectors.
  explicit Optimiser(torch::nn::Module& network);

  // Makes one step after backward(): clips the gradients, updates the weights and the average, and
  // clears the gradients. `step` counts from 0. Returns the norm of the gradients before clipping.
  double Step(const TrainSettings& settings, int64_t step);

  // Returns the state itself, not a copy. `step` of the next Step must follow that of the state.
  const OptimiserState& state() const { return state_; }
  void Restore(const OptimiserState& state);

 private:
  OptimiserState state_;
  torch::Tensor gradients_;
};

// Copies a flat vector into the network's weights. The sizes must be equal.
void SetWeights(torch::nn::Module& network, const torch::Tensor& flat);

// Returns the layout of the flat vector: "name height x width ...;" for each weight, in order.
std::string LayoutOf(const torch::nn::Module& network);

}  // namespace parallax
