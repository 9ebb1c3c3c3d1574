#include "worker/train/network/convolution.h"

#include <ATen/ops/convolution.h>
#include <ATen/ops/convolution_backward.h>
#include <torch/csrc/autograd/custom_function.h>

#include <string>

#include "worker/train/network/group_norm.h"

namespace parallax {
namespace {

using torch::Tensor;
using torch::autograd::AutogradContext;
using torch::autograd::tensor_list;

using Sizes = std::vector<int64_t>;

// Planes are fastest with channels last, volumes with channels first.
Tensor ToBfloat16(const Tensor& t) {
  return t.to(t.options().dtype(torch::kBFloat16), false, false,
              t.dim() == 4 ? torch::MemoryFormat::ChannelsLast : torch::MemoryFormat::Contiguous);
}

struct Bfloat16Convolution : public torch::autograd::Function<Bfloat16Convolution> {
  static Tensor forward(AutogradContext* context, const Tensor& input_in, const Tensor& weight_in,
                        const c10::optional<Tensor>& bias, const Sizes& stride,
                        const Sizes& padding, const Sizes& dilation) {
    const Tensor input = ToBfloat16(input_in), weight = weight_in.to(torch::kBFloat16);
    context->save_for_backward({input, weight});
    context->saved_data["bias"] = bias.has_value();
    context->saved_data["stride"] = stride;
    context->saved_data["padding"] = padding;
    context->saved_data["dilation"] = dilation;
    c10::optional<Tensor> small_bias;
    if (bias.has_value()) small_bias = bias->to(torch::kBFloat16);
    return at::convolution(input, weight, small_bias, stride, padding, dilation, false,
                           Sizes(stride.size(), 0), 1);
  }

  static tensor_list backward(AutogradContext* context, tensor_list gradients) {
    const auto saved = context->get_saved_variables();
    const auto sizes = [&](const char* key) { return context->saved_data[key].toIntVector(); };
    const Sizes stride = sizes("stride"), bias_size{saved[1].size(0)};
    const bool bias = context->saved_data["bias"].toBool();
    const auto [input, weight, bias_gradient] = at::convolution_backward(
        ToBfloat16(gradients[0]), saved[0], saved[1],
        bias ? at::OptionalIntArrayRef(bias_size) : at::OptionalIntArrayRef(), stride,
        sizes("padding"), sizes("dilation"), false, Sizes(stride.size(), 0), 1,
        {context->needs_input_grad(0), true, bias});
    // Autograd turns them into the type of what they belong to.
    return {input, weight, bias_gradient, Tensor(), Tensor(), Tensor()};
  }
};

}  // namespace

bool ConvolvesInBfloat16() {
  static const bool has = __builtin_cpu_supports("avx512bf16");
  return has && torch::GradMode::is_enabled();
}

ConvolutionImpl::ConvolutionImpl(const ConvolutionShape& shape) : shape_(shape) {
  Sizes sizes(static_cast<size_t>(shape.dimensions + 2), shape.kernel);
  sizes[0] = shape.out;
  sizes[1] = shape.in;
  weight_ = register_parameter("weight", torch::zeros(sizes));
  if (shape.bias) bias_ = register_parameter("bias", torch::zeros({shape.out}));
}

Tensor ConvolutionImpl::forward(const Tensor& input) {
  const auto all = [&](int64_t value) {
    return Sizes(static_cast<size_t>(shape_.dimensions), value);
  };
  const Sizes stride = all(shape_.stride), padding = all(shape_.dilation * (shape_.kernel / 2));
  // Torch's own code for one pixel, which waits for a better BLAS, is not for dilated ones.
  const Sizes dilation = all(shape_.kernel == 1 ? 2 : shape_.dilation);
  const auto bias = shape_.bias ? c10::optional<Tensor>(bias_) : c10::nullopt;
  // A single output is a disparity or its score, for which eight bits are too few.
  if (ConvolvesInBfloat16() && shape_.out > 1) {
    return Bfloat16Convolution::apply(input, weight_, bias, stride, padding, dilation);
  }
  return at::convolution(input.to(torch::kFloat), weight_, bias, stride, padding, dilation, false,
                         all(0), 1);
}

LayersImpl::LayersImpl(const std::vector<ConvolutionShape>& shapes) {
  for (const ConvolutionShape& shape : shapes) {
    const size_t at = 3 * layers_.size();  // Names as in a torch::nn::Sequential with its ReLUs.
    const auto convolution = register_module(std::to_string(at), Convolution(shape));
    const torch::nn::GroupNorm norm(shape.out / kChannelsInGroup, shape.out);
    layers_.emplace_back(convolution, register_module(std::to_string(at + 1), norm));
  }
}

Tensor LayersImpl::forward(Tensor t) {
  for (auto& [convolution, norm] : layers_) {
    t = convolution->forward(t);
    t = t.scalar_type() == torch::kBFloat16 ? GroupNormRelu(t, norm->weight, norm->bias)
                                            : norm->forward(t).relu_();
  }
  return t;
}

}  // namespace parallax
