// Group normalisation and ReLU in one pass over bfloat16, for training: torch's own brings its
// input into float32 with channels first, and back.
#pragma once

#include <torch/types.h>

namespace parallax {

inline constexpr int64_t kChannelsInGroup = 8;

// Normalises groups of eight channels, scales and shifts each channel (`scale` and `shift` are
// float32, one value a channel), and sets negative values to 0. `t` is bfloat16: (batch, channels,
// height, width) with channels last, or (batch, channels, depth, height, width) with channels first
// and depth * height * width a multiple of 8. The result is like it. Deterministic: each image is
// computed by one thread.   Source: Wu and He, "Group Normalization", ECCV 2018.
torch::Tensor GroupNormRelu(const torch::Tensor& t, const torch::Tensor& scale,
                            const torch::Tensor& shift);

}  // namespace parallax
