#include <algorithm>
#include <vector>

#include "worker/train/network/correlation.h"

namespace parallax {
namespace {

using torch::Tensor;

// Sum of `product` over the channels of each group: (batch, groups, height, width).
Tensor SumOfGroups(const Tensor& product, int64_t groups) {
  const auto size = product.sizes();
  return product.reshape({size[0], groups, size[1] / groups, size[2], size[3]}).sum(2);
}

}  // namespace

Tensor PlainCorrelationVolume(const Tensor& left, const Tensor& right, int64_t groups,
                              int64_t disparities) {
  const int64_t width = left.size(3);
  std::vector<Tensor> slices;
  for (int64_t d = 0; d < disparities; ++d) {
    const Tensor shifted = torch::constant_pad_nd(
        right.slice(3, 0, std::max<int64_t>(0, width - d)), {std::min(d, width), 0});
    slices.push_back(SumOfGroups(left * shifted, groups));
  }
  return torch::stack(slices, 2);
}

Tensor PlainLocalCorrelation(const Tensor& left, const Tensor& right, const Tensor& disparity,
                             int64_t groups, int64_t radius) {
  const int64_t width = left.size(3);
  const auto column = [&](const Tensor& at) {
    const Tensor inside = ((at >= 0) & (at < width)).to(torch::kFloat);
    return right.gather(3, at.clamp(0, width - 1).to(torch::kLong).expand(right.sizes())) * inside;
  };
  const Tensor columns = torch::arange(width, torch::kFloat).view({1, 1, 1, width});
  std::vector<Tensor> slices;
  for (int64_t r = -radius; r <= radius; ++r) {
    const Tensor at = columns - static_cast<double>(r) - disparity, first = at.floor();
    const Tensor weight = at - first;
    slices.push_back(
        SumOfGroups(left * (column(first) * (1 - weight) + column(first + 1) * weight), groups));
  }
  return torch::stack(slices, 2).flatten(1, 2);
}

}  // namespace parallax
