// Muon for the weights of convolutions and AdamW for all others, over one flat vector of all
// weights, with a moving average of the weights beside it. The vector is flat, so that a checkpoint
// is four vectors and equal runs write equal bytes.
//   Sources: Jordan et al., "Muon: an optimizer for hidden layers in neural networks", 2024;
//   Loshchilov and Hutter, "Decoupled Weight Decay Regularization", ICLR 2019.
#pragma once

#include <torch/nn/module.h>
#include <torch/types.h>

#include <string>
#include <vector>

#include "worker/train/network/settings.h"

namespace parallax {

// The flat vectors of a checkpoint.
struct OptimiserState {
  // One-dimensional, float32. `mean` is the momentum, `square` is only used by AdamW.
  torch::Tensor weights, average, mean, square;
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
  // A convolution's weights, (outputs, inputs * taps), within the flat vectors.
  struct Matrix {
    int64_t at, rows, columns;
  };

  OptimiserState state_;
  torch::Tensor gradients_;
  std::vector<Matrix> matrices_;
};

// Returns a matrix with nearly the singular vectors of `matrix`, float32, and singular values
// between about 0.7 and 1.2: five Newton-Schulz iterations.
torch::Tensor Orthogonalised(const torch::Tensor& matrix);

// Copies a flat vector into the network's weights. The sizes must be equal.
void SetWeights(torch::nn::Module& network, const torch::Tensor& flat);

// Returns the layout of the flat vector: "name height x width ...;" for each weight, in order.
std::string LayoutOf(const torch::nn::Module& network);

}  // namespace parallax
