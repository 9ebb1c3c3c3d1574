// Convolutions of two or three dimensions, alone and with normalisation, as modules of the network.
// While gradients are recorded, and on processors with instructions for it (AVX-512 BF16), they are
// computed in bfloat16, with sums in float32: half the time of a training step. Weights are
// float32, and predictions are wholly float32 everywhere.
#pragma once

#include <torch/nn/module.h>
#include <torch/nn/modules/normalization.h>
#include <torch/nn/pimpl.h>
#include <torch/types.h>

#include <utility>
#include <vector>

namespace parallax {

// Returns whether convolutions are now computed in bfloat16.
bool ConvolvesInBfloat16();

// The shape of a convolution. The output has the input's size divided by `stride`.
struct ConvolutionShape {
  int64_t in, out, kernel;
  int64_t stride = 1, dilation = 1;
  int64_t dimensions = 2;
  bool bias = false;
};

class ConvolutionImpl : public torch::nn::Module {
 public:
  explicit ConvolutionImpl(const ConvolutionShape& shape);

  // `input` is (batch, in, [depth,] height, width), float32 or bfloat16; the result is of the type
  // that is computed in, float32 where there is one output.
  torch::Tensor forward(const torch::Tensor& input);

 private:
  const ConvolutionShape shape_;
  torch::Tensor weight_, bias_;
};
TORCH_MODULE(Convolution);

// Convolutions, each followed by normalisation of groups of eight channels and ReLU.
class LayersImpl : public torch::nn::Module {
 public:
  explicit LayersImpl(const std::vector<ConvolutionShape>& shapes);

  torch::Tensor forward(torch::Tensor t);

 private:
  std::vector<std::pair<Convolution, torch::nn::GroupNorm>> layers_;
};
TORCH_MODULE(Layers);

}  // namespace parallax
