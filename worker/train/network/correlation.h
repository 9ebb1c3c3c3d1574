// Matching costs of rectified pairs as differentiable operations on CPU tensors (float32).
// Deterministic: each row of each image is computed by one thread in a fixed order.
#pragma once

#include <torch/types.h>

namespace parallax {

// Computes the group-wise correlation of `left` and `right`, both of shape (batch, channels,
// height, width) with channels a multiple of `groups`. Returns a tensor of shape (batch, groups,
// disparities, height, width), whose element (g, d, y, x) is the sum over the group's channels of
// left(x) * right(x - d), and 0 where x < d.
//   Source: Guo et al., "Group-wise Correlation Stereo Network", CVPR 2019.
torch::Tensor CorrelationVolume(const torch::Tensor& left, const torch::Tensor& right,
                                int64_t groups, int64_t disparities);

// Computes the group-wise correlation around a given disparity, of shape (batch, 1, height, width),
// in pixels of the features. Returns a tensor of shape (batch, groups * (2 radius + 1), height,
// width), whose channel g * (2 radius + 1) + r + radius compares left(x) with right(x - disparity -
// r), linearly interpolated between columns and 0 outside of the image. No gradient flows to
// `disparity`.
torch::Tensor LocalCorrelation(const torch::Tensor& left, const torch::Tensor& right,
                               const torch::Tensor& disparity, int64_t groups, int64_t radius);

// Compute the same by torch's own operations: ten times slower, but traceable into TorchScript.
torch::Tensor PlainCorrelationVolume(const torch::Tensor& left, const torch::Tensor& right,
                                     int64_t groups, int64_t disparities);
torch::Tensor PlainLocalCorrelation(const torch::Tensor& left, const torch::Tensor& right,
                                    const torch::Tensor& disparity, int64_t groups, int64_t radius);

}  // namespace parallax
