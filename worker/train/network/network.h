// The built-in stereo network: 0.64 million weights, made to be trained in minutes on a
// CPU.
//
// Siamese features at 1/2, 1/4, 1/8 and 1/16; group-wise correlation of normalised features over
// all disparities at 1/4; a light 3D hourglass steered by the left image's features; a soft-argmin
// about the best disparity; convex upsampling to 1/2, where a local correlation corrects the
// disparity, and again to full size. Group normalisation throughout: no statistics of batches.
//   Sources: Guo et al., GwcNet, CVPR 2019 (group-wise correlation); Bangunharcana et al., CoEx,
//   IROS 2021 (guided excitation); Teed and Deng, RAFT, ECCV 2020 (convex upsampling); Xu et al.,
//   "Adaptive Multi-Modal Cross-Entropy Loss for Stereo Matching", CVPR 2024 (distribution loss,
//   one mode read out).
#pragma once

#include <torch/nn/module.h>
#include <torch/nn/modules/container/sequential.h>
#include <torch/nn/modules/conv.h>
#include <torch/types.h>

#include <memory>

#include "worker/train/network/convolution.h"

namespace parallax {

// Sizes must be multiples of this; PredictDisparity pads.
inline constexpr int64_t kSizeMultiple = 32;

// Disparities at three resolutions, for the loss.
struct StereoOutput {
  torch::Tensor disparity;  // (batch, 1, height, width), pixels of the input.
  torch::Tensor half;       // The same at 1/2, before the correction; still pixels of the input.
  torch::Tensor quarter;    // At 1/4, pixels of the input.
  // (batch, disparities / 4, height / 4, width / 4): log-probabilities at 1/4.
  torch::Tensor log_scores;
};

// The network; see the head of this file.
class StereoNetwork : public torch::nn::Module {
 public:
  StereoNetwork();

  // Predicts disparities. `left` and `right` have the shape (batch, 3, height, width) and values in
  // [0, 1]; their sizes are multiples of kSizeMultiple; `max_disparity` is in pixels, a multiple of
  // 4 (16 or more).
  StereoOutput Forward(const torch::Tensor& left, const torch::Tensor& right,
                       int64_t max_disparity);

  // Makes Forward use torch's own operations only, so that it can be traced. It is slower then.
  void UsePlainOperations() { plain_ = true; }

 private:
  struct Features {
    torch::Tensor half, quarter, eighth, sixteenth, match;
  };
  Features Describe(const torch::Tensor& images);
  torch::Tensor Aggregate(const torch::Tensor& volume, const Features& left);

  Layers half_{nullptr}, quarter_{nullptr}, eighth_{nullptr}, sixteenth_{nullptr};  // Downwards.
  Layers up_eighth_{nullptr}, up_quarter_{nullptr}, lateral_eighth_{nullptr},
      lateral_quarter_{nullptr};
  torch::nn::Sequential match_;
  // The hourglass, downwards and up again.
  Layers cost_eighth_{nullptr}, cost_sixteenth_{nullptr};
  Layers narrow_sixteenth_{nullptr}, merge_eighth_{nullptr}, narrow_eighth_{nullptr};
  torch::nn::Sequential merge_quarter_, score_, guide_quarter_, guide_eighth_, guide_sixteenth_;
  torch::nn::Sequential upsample_half_, correction_, upsample_full_;
  Layers correct_{nullptr};
  bool plain_ = false;
};

// Sets the weights to He et al.'s normal distribution, drawn from `seed` alone, tensor by tensor in
// order of names.
void InitialiseWeights(StereoNetwork& network, uint64_t seed);

// Upsamples disparity to twice the size: each fine pixel is a weighted mean of the 3x3 coarse
// pixels around it. `weights` is (batch, 36, height, width): softmax over the nine of each of the
// four fine pixels.
torch::Tensor ConvexUpsample(const torch::Tensor& coarse, const torch::Tensor& weights);

// Returns the mean disparity of the five candidates about the most likely one, (batch, 1, height,
// width), in candidates. `log_scores` is (batch, candidates, height, width).
torch::Tensor ModeDisparity(const torch::Tensor& log_scores);

}  // namespace parallax
