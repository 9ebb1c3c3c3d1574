#include "worker/train/network/network.h"

#include <ATen/ops/convolution.h>
#include <ATen/ops/einsum.h>
#include <gtest/gtest.h>

#include <cmath>

#include "worker/train/network/convolution.h"
#include "worker/train/network/correlation.h"
#include "worker/train/network/group_norm.h"
#include "worker/train/network/loss.h"
#include "worker/train/network/optimiser.h"
#include "worker/train/trained_predictor.h"

namespace parallax {
namespace {

using torch::Tensor;

// Values in [-1, 1) from a formula, so that tests draw nothing.
Tensor Waves(torch::IntArrayRef sizes, double pace) {
  return torch::sin(torch::arange(c10::multiply_integers(sizes), torch::kDouble) * pace)
      .to(torch::kFloat)
      .view(sizes);
}

// The same without a pattern: products of such tensors do not cancel.
Tensor Noise(torch::IntArrayRef sizes, double pace) {
  return torch::sin(torch::arange(c10::multiply_integers(sizes), torch::kDouble).square() * pace)
      .to(torch::kFloat)
      .view(sizes);
}

// Largest difference between the gradient of sum(f(x) * w) and central differences, over some
// elements.
template <typename Fn>
double GradientError(const Tensor& x, Fn f) {
  const Tensor leaf = x.clone().requires_grad_();
  const Tensor out = f(leaf);
  const Tensor w = Waves(out.sizes(), 0.37);
  (out * w).sum().backward();
  const torch::NoGradGuard no_grad;
  double worst = 0;
  for (int64_t i = 0; i < x.numel(); i += 7) {
    const auto moved = [&](double by) {
      Tensor y = x.clone();
      y.view(-1)[i] += by;
      return (f(y) * w).sum().template item<double>();
    };
    const double slope = (moved(0.5) - moved(-0.5));  // Linear in each element.
    worst = std::max(worst, std::abs(slope - leaf.grad().view(-1)[i].template item<double>()));
  }
  return worst;
}

TEST(Correlation, VolumeIsTheSumOfProductsAndItsGradientIsRight) {
  const Tensor left = Waves({2, 4, 3, 11}, 0.7), right = Waves({2, 4, 3, 11}, 1.3);
  const Tensor volume = CorrelationVolume(left, right, 2, 5);
  for (const auto& [n, g, d, y, x] : {std::array<int64_t, 5>{0, 0, 0, 0, 0},
                                      {1, 1, 4, 2, 10},
                                      {0, 1, 3, 1, 5},
                                      {1, 0, 4, 2, 3}}) {
    double sum = 0;
    for (int64_t c = 2 * g; c < 2 * g + 2 && x >= d; ++c) {
      sum += (left[n][c][y][x] * right[n][c][y][x - d]).item<double>();
    }
    EXPECT_NEAR(volume[n][g][d][y][x].item<double>(), sum, 1e-5);
  }
  EXPECT_LT(GradientError(left, [&](const Tensor& t) { return CorrelationVolume(t, right, 2, 5); }),
            1e-3);
  EXPECT_LT(GradientError(right, [&](const Tensor& t) { return CorrelationVolume(left, t, 2, 5); }),
            1e-3);
}

TEST(Correlation, LocalAgreesWithTheVolumeAndItsGradientIsRight) {
  const Tensor left = Waves({1, 4, 3, 12}, 0.7), right = Waves({1, 4, 3, 12}, 1.3);
  const Tensor volume = CorrelationVolume(left, right, 2, 8);
  const Tensor local = LocalCorrelation(left, right, torch::full({1, 1, 3, 12}, 3.0f), 2, 1);
  for (int64_t g = 0; g < 2; ++g) {
    for (int64_t r = -1; r <= 1; ++r) {
      for (int64_t x = 4; x < 12; ++x) {
        EXPECT_NEAR(local[0][3 * g + r + 1][1][x].item<double>(),
                    volume[0][g][3 + r][1][x].item<double>(), 1e-5);
      }
    }
  }
  const Tensor between = Waves({1, 1, 3, 12}, 0.9) * 2 + 2.3;
  for (const int64_t radius : {2, 3}) {
    const auto of = [&](const Tensor& l, const Tensor& r) {
      return LocalCorrelation(l, r, between, 2, radius);
    };
    EXPECT_LT(GradientError(left, [&](const Tensor& t) { return of(t, right); }), 1e-3) << radius;
    EXPECT_LT(GradientError(right, [&](const Tensor& t) { return of(left, t); }), 1e-3) << radius;
  }
}

TEST(Correlation, PlainOperationsAgree) {
  const Tensor left = Waves({2, 8, 3, 12}, 0.7), right = Waves({2, 8, 3, 12}, 1.3);
  EXPECT_TRUE(torch::allclose(PlainCorrelationVolume(left, right, 4, 16),
                              CorrelationVolume(left, right, 4, 16), 1e-4, 1e-5));
  const Tensor around = Waves({2, 1, 3, 12}, 0.9) * 8 + 4;
  EXPECT_TRUE(torch::allclose(PlainLocalCorrelation(left, right, around, 2, 3),
                              LocalCorrelation(left, right, around, 2, 3), 1e-4, 1e-5));
}

TEST(Convolution, TrainingAgreesWithPredictionToTheBitsOfItsType) {
  struct Case {
    ConvolutionShape shape;
    std::vector<int64_t> input;
  };
  const Case cases[] = {{{8, 16, 3, 2, 1, 2, true}, {2, 8, 12, 20}},
                        {{8, 16, 3, 1, 2}, {1, 8, 12, 20}},
                        {{8, 16, 1}, {2, 8, 6, 10}},
                        {{8, 1, 3}, {2, 8, 6, 10}},
                        {{8, 16, 3, 2, 1, 3}, {2, 8, 4, 6, 10}},
                        {{16, 8, 1, 1, 1, 3}, {1, 16, 4, 6, 10}}};
  for (const Case& c : cases) {
    Convolution convolution(c.shape);
    std::vector<Tensor> results;
    Tensor input = Noise(c.input, 0.7).requires_grad_();
    std::vector<Tensor> leaves{input};
    for (Tensor& weight : convolution->parameters()) {
      weight.set_data(Noise(weight.sizes(), 0.31));
      leaves.push_back(weight);
    }
    const Tensor seen = convolution->forward(input);
    const Tensor slope = Noise(seen.sizes(), 0.17);
    seen.backward(slope.to(seen.scalar_type()));
    {
      const torch::NoGradGuard no_grad;
      const Tensor exact = convolution->forward(input);
      EXPECT_EQ(exact.scalar_type(), torch::kFloat);
      EXPECT_EQ(seen.sizes(), exact.sizes());
      EXPECT_LT((seen - exact).norm().item<double>(), 0.01 * exact.norm().item<double>());
      if (c.shape.out == 1) {
        EXPECT_TRUE(torch::equal(seen, exact));
      }
    }
    // The same by torch's own derivative in float32.
    const auto all = [&](int64_t value) {
      return std::vector<int64_t>(static_cast<size_t>(c.shape.dimensions), value);
    };
    std::vector<Tensor> copies;
    for (const Tensor& leaf : leaves) copies.push_back(leaf.detach().clone().requires_grad_());
    at::convolution(copies[0], copies[1], c.shape.bias ? copies[2] : Tensor(), all(c.shape.stride),
                    all(c.shape.dilation * (c.shape.kernel / 2)), all(c.shape.dilation), false,
                    all(0), 1)
        .backward(slope);
    for (size_t i = 0; i < leaves.size(); ++i) {
      ASSERT_TRUE(leaves[i].grad().defined()) << i;
      EXPECT_EQ(leaves[i].grad().scalar_type(), torch::kFloat);
      EXPECT_LT((leaves[i].grad() - copies[i].grad()).norm().item<double>(),
                0.02 * copies[i].grad().norm().item<double>())
          << i;
    }
  }
}

TEST(GroupNorm, AgreesWithTorchsInBothLayouts) {
  for (const std::vector<int64_t>& sizes :
       {std::vector<int64_t>{2, 16, 6, 10}, {2, 24, 2, 6, 10}}) {
    const int64_t channels = sizes[1];
    const bool last = sizes.size() == 4;
    const auto format = last ? torch::MemoryFormat::ChannelsLast : torch::MemoryFormat::Contiguous;
    const Tensor values = (Waves(sizes, 0.7) * 2 + 0.5).to(torch::kBFloat16);
    Tensor scale = Waves({channels}, 0.9) + 1.5, shift = Waves({channels}, 1.9) / 2;
    std::vector<Tensor> leaves, copies;
    for (const Tensor& t : {values.contiguous(format), scale, shift}) {
      leaves.push_back(t.clone().requires_grad_());
      copies.push_back(t.to(torch::kFloat).clone().requires_grad_());
    }
    const Tensor seen = GroupNormRelu(leaves[0], leaves[1], leaves[2]);
    const Tensor exact =
        torch::relu(torch::group_norm(copies[0], channels / 8, copies[1], copies[2]));
    EXPECT_LT((seen - exact).norm().item<double>(), 0.005 * exact.norm().item<double>());
    const Tensor slope = Waves(sizes, 0.17).to(torch::kBFloat16);
    seen.backward(slope);
    exact.backward(slope.to(torch::kFloat));
    for (size_t i = 0; i < 3; ++i) {
      EXPECT_LT((leaves[i].grad() - copies[i].grad()).norm().item<double>(),
                0.01 * copies[i].grad().norm().item<double>())
          << i << " of " << sizes.size();
    }
  }
  const Tensor broken = torch::full({1, 8, 2, 2}, NAN).to(torch::kBFloat16);
  const Tensor result = GroupNormRelu(broken, torch::ones({8}), torch::zeros({8}));
  EXPECT_TRUE(result.isnan().all().item<bool>());
}

TEST(Optimiser, OrthogonalisedMatricesHaveTheSameDirectionsAllOfAboutOneLength) {
  for (const auto& [rows, columns] : {std::pair<int64_t, int64_t>{8, 72}, {48, 16}, {96, 96}}) {
    const Tensor matrix = Noise({rows, columns}, 0.7);
    const Tensor result = Orthogonalised(matrix);
    ASSERT_EQ(result.sizes(), matrix.sizes());
    // For M = U S V' and the result U D V', the product M' result = V S D V' is symmetric.
    const Tensor product = torch::einsum("ki,kj->ij", {matrix, result});
    EXPECT_LT((product - product.t()).norm().item<double>(), 1e-3 * product.norm().item<double>());
    // Few of the singular values are too small for five iterations, none becomes large.
    const double length = result.norm().item<double>() / std::sqrt(std::min(rows, columns));
    EXPECT_GT(length, 0.6) << rows << "x" << columns;
    EXPECT_LT(length, 1.2) << rows << "x" << columns;
  }
  EXPECT_EQ(Orthogonalised(torch::zeros({4, 4})).norm().item<float>(), 0);
}

TEST(Network, ModeDisparityReadsOneModeBetweenCandidates) {
  Tensor scores = torch::full({1, 12, 1, 2}, -20.0f);
  scores.index_put_({0, 3, 0, 0}, 0.0f);
  scores.index_put_({0, 4, 0, 0}, 0.0f);
  scores.index_put_({0, 10, 0, 0}, -0.1f);  // Another surface, almost as likely.
  scores.index_put_({0, 0, 0, 1}, 0.0f);
  const Tensor disparity = ModeDisparity(torch::log_softmax(scores, 1));
  EXPECT_NEAR(disparity[0][0][0][0].item<double>(), 3.5, 1e-4);
  EXPECT_NEAR(disparity[0][0][0][1].item<double>(), 0, 1e-4);
}

TEST(Network, ConvexUpsampleKeepsConstantsAndRange) {
  const Tensor weights = Waves({1, 36, 4, 5}, 0.61) * 3;
  EXPECT_TRUE(torch::allclose(ConvexUpsample(torch::full({1, 1, 4, 5}, 7.0f), weights),
                              torch::full({1, 1, 8, 10}, 7.0f)));
  const Tensor coarse = torch::arange(20, torch::kFloat).view({1, 1, 4, 5});
  const Tensor fine = ConvexUpsample(coarse, weights);
  EXPECT_GE(fine.min().item<double>(), 0);
  EXPECT_LE(fine.max().item<double>(), 19);
  // Sharp weights on the centre give the nearest coarse pixel.
  Tensor centre = torch::zeros({1, 4, 9, 4, 5});
  centre.select(2, 4).fill_(100);
  const Tensor nearest = ConvexUpsample(coarse, centre.view({1, 36, 4, 5}));
  EXPECT_NEAR(nearest[0][0][5][7].item<double>(), coarse[0][0][2][3].item<double>(), 1e-4);
}

TEST(Network, GradientsFlowIntoEveryWeight) {
  StereoNetwork network;
  InitialiseWeights(network, 3);
  const Tensor left = Waves({1, 3, 64, 128}, 0.9) / 2 + 0.5,
               right = Waves({1, 3, 64, 128}, 0.8) / 2 + 0.5;
  const StereoOutput output = network.Forward(left, right, 64);
  EXPECT_EQ(output.disparity.sizes(), (std::vector<int64_t>{1, 1, 64, 128}));
  const Tensor truth = torch::full({1, 1, 64, 128}, 20.0f);
  LossOf(output, truth, torch::ones_like(truth)).loss.backward();
  for (const auto& item : network.named_parameters()) {
    ASSERT_TRUE(item.value().grad().defined()) << item.key();
    EXPECT_GT(item.value().grad().abs().sum().item<double>(), 0) << item.key();
  }
}

TEST(Network, InitialWeightsDependOnTheSeedOnly) {
  StereoNetwork a, b, c;
  InitialiseWeights(a, 1);
  InitialiseWeights(b, 1);
  InitialiseWeights(c, 2);
  EXPECT_TRUE(torch::equal(Optimiser(a).state().weights, Optimiser(b).state().weights));
  EXPECT_FALSE(torch::equal(Optimiser(a).state().weights, Optimiser(c).state().weights));
}

TEST(Loss, IgnoresPixelsWithoutWeight) {
  StereoNetwork network;
  InitialiseWeights(network, 3);
  const torch::NoGradGuard no_grad;
  const Tensor image = Waves({1, 3, 32, 64}, 0.9) / 2 + 0.5;
  const StereoOutput output = network.Forward(image, image, 64);
  Tensor truth = torch::full({1, 1, 32, 64}, 20.0f), weight = torch::ones_like(truth);
  weight.slice(3, 0, 32).zero_();
  const BatchLoss before = LossOf(output, truth, weight);
  truth.slice(3, 0, 32).fill_(50);
  const BatchLoss after = LossOf(output, truth, weight);
  EXPECT_EQ(before.loss.item<float>(), after.loss.item<float>());
  EXPECT_EQ(before.epe_px, after.epe_px);
  EXPECT_EQ(LossOf(output, truth, torch::zeros_like(weight)).loss.item<float>(), 0);
}

TEST(NetworkSize, PadsReducesAndLimits) {
  struct Case {
    int width, height;
    double max_disparity;
    NetworkSize wanted;
  };
  const Case cases[] = {
      {640, 360, 0, {640, 360, 640, 384, 192}},
      {641, 353, 0, {641, 353, 672, 384, 192}},
      {1, 1, 0, {1, 1, 32, 32, 192}},
      {2560, 1440, 0, {1280, 720, 1280, 736, 192}},
      {2560, 1440, 500, {1280, 720, 1280, 736, 256}},
      {640, 360, 50, {640, 360, 640, 384, 64}},
      {1000, 500, 768, {500, 250, 512, 256, 384}},
  };
  for (const Case& c : cases) {
    const NetworkSize size = ChooseNetworkSize(c.width, c.height, 192, c.max_disparity);
    EXPECT_EQ(std::tuple(size.width, size.height, size.padded_width, size.padded_height,
                         size.max_disparity),
              std::tuple(c.wanted.width, c.wanted.height, c.wanted.padded_width,
                         c.wanted.padded_height, c.wanted.max_disparity))
        << c.width << "x" << c.height;
  }
}

TEST(NetworkSize, SmallPairsAreEnlargedAsFarAsTheSearchReaches) {
  const auto seen = [](int width, float most) {
    ImageF disparity_px(width, 10, 5.0f);
    for (int x = 0; x < width / 10; ++x) disparity_px(x, 0) = most;
    return disparity_px;
  };
  EXPECT_DOUBLE_EQ(ChooseEnlargement(seen(400, 20), 192), 2) << "at most twice";
  EXPECT_DOUBLE_EQ(ChooseEnlargement(seen(1000, 20), 192), 1.28) << "at most 1,280 px wide";
  EXPECT_NEAR(ChooseEnlargement(seen(400, 160), 192), 192 / (1.1 * 160), 1e-6);
  EXPECT_LT(ChooseEnlargement(seen(400, 190), 192), 1);
  EXPECT_DOUBLE_EQ(ChooseEnlargement(seen(2560, 20), 192), 0.5);
  EXPECT_DOUBLE_EQ(ChooseEnlargement(seen(400, 0), 192), 2);
}

TEST(NetworkSize, TheFirstOfTwoLooksIsSmaller) {
  const NetworkSize size = ChooseNetworkSize(1000, 500, 192, 768, 0.5);
  EXPECT_EQ(std::tuple(size.width, size.height, size.max_disparity), std::tuple(250, 125, 192));
}

TEST(JoinLooks, APixelTakesTheFirstLookWhereItIsSurerByFar) {
  Look coarse{ImageF(120, 60, 20.0f), ImageF(120, 60, 0.9f)};
  Look fine{ImageF(120, 60, 30.0f), ImageF(120, 60, 0.2f)};
  for (int y = 0; y < 60; ++y) {
    for (int x = 60; x < 120; ++x) fine.certainty(x, y) = 0.8f;
  }
  fine.certainty(90, 30) = 0;  // A single pixel is no wall.
  const ImageF joined = JoinLooks(coarse, fine);
  EXPECT_EQ(joined(10, 30), 20);
  EXPECT_EQ(joined(90, 30), 30);
  EXPECT_EQ(joined(110, 5), 30);
}

}  // namespace
}  // namespace parallax
