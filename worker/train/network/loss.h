// The loss of a batch, and the errors of its disparities.
#pragma once

#include "worker/train/network/network.h"

namespace parallax {

// Loss and errors of one batch.
struct BatchLoss {
  torch::Tensor loss;  // A scalar with its graph.
  double epe_px = 0;   // Mean |error| of `disparity` over visible pixels.
  double bad3 = 0;     // Share of visible pixels that are off by more than 3 px.
};

// Returns the loss of a batch. `disparity` and `weight` have the shape (batch, 1, height, width):
// truth in pixels, and each pixel's weight (0 without truth, 1 where both eyes see it, between
// where one does).
//
// The sum of: at 1/4 the cross-entropy between the candidates' probabilities and a Laplace
// distribution about the truth; and at each resolution the smooth L1 distance.
//   Source: Xu et al., CVPR 2024 (see network.h).
BatchLoss LossOf(const StereoOutput& output, const torch::Tensor& disparity,
                 const torch::Tensor& weight);

}  // namespace parallax
