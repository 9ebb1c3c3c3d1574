#include "worker/train/network/correlation.h"

#include <ATen/Parallel.h>
#include <torch/csrc/autograd/custom_function.h>

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

namespace parallax {
namespace {

using torch::Tensor;
using torch::autograd::AutogradContext;
using torch::autograd::tensor_list;

struct Shape {
  int64_t batch, channels, height, width;
  // Start of the row (n, c, y).
  int64_t Row(int64_t n, int64_t c, int64_t y) const {
    return ((n * channels + c) * height + y) * width;
  }
};

Shape ShapeOf(const Tensor& t) { return {t.size(0), t.size(1), t.size(2), t.size(3)}; }

// Calls `row(n, y)` for every row of every image, in parallel.
template <typename RowFn>
void ForEachRow(const Shape& shape, RowFn row) {
  at::parallel_for(0, shape.batch * shape.height, 1, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) row(i / shape.height, i % shape.height);
  });
}

// ---- The whole range of disparities

struct VolumeFunction : public torch::autograd::Function<VolumeFunction> {
  static Tensor forward(AutogradContext* context, const Tensor& left_in, const Tensor& right_in,
                        int64_t groups, int64_t disparities) {
    const Tensor left = left_in.contiguous(), right = right_in.contiguous();
    context->save_for_backward({left, right});
    context->saved_data["groups"] = groups;
    const Shape in = ShapeOf(left);
    const int64_t in_group = in.channels / groups;
    Tensor volume =
        torch::zeros({in.batch, groups, disparities, in.height, in.width}, left.options());
    const float *l = left.data_ptr<float>(), *r = right.data_ptr<float>();
    float* out = volume.data_ptr<float>();
    ForEachRow(in, [&](int64_t n, int64_t y) {
      for (int64_t c = 0; c < in.channels; ++c) {
        const float *lrow = l + in.Row(n, c, y), *rrow = r + in.Row(n, c, y);
        for (int64_t d = 0; d < disparities; ++d) {
          float* orow =
              out + (((n * groups + c / in_group) * disparities + d) * in.height + y) * in.width;
          for (int64_t x = d; x < in.width; ++x) orow[x] += lrow[x] * rrow[x - d];
        }
      }
    });
    return volume;
  }

  static tensor_list backward(AutogradContext* context, tensor_list gradients) {
    const auto saved = context->get_saved_variables();
    const Tensor &left = saved[0], &right = saved[1], gradient = gradients[0].contiguous();
    const int64_t groups = context->saved_data["groups"].toInt();
    const Shape in = ShapeOf(left);
    const int64_t in_group = in.channels / groups, disparities = gradient.size(2);
    Tensor left_gradient = torch::zeros_like(left), right_gradient = torch::zeros_like(right);
    const float *l = left.data_ptr<float>(), *r = right.data_ptr<float>(),
                *g = gradient.data_ptr<float>();
    float *lg = left_gradient.data_ptr<float>(), *rg = right_gradient.data_ptr<float>();
    ForEachRow(in, [&](int64_t n, int64_t y) {
      for (int64_t c = 0; c < in.channels; ++c) {
        const int64_t row = in.Row(n, c, y);
        for (int64_t d = 0; d < disparities; ++d) {
          const float* grow =
              g + (((n * groups + c / in_group) * disparities + d) * in.height + y) * in.width;
          for (int64_t x = d; x < in.width; ++x) lg[row + x] += grow[x] * r[row + x - d];
          for (int64_t x = d; x < in.width; ++x) rg[row + x - d] += grow[x] * l[row + x];
        }
      }
    });
    return {left_gradient, right_gradient, Tensor(), Tensor()};
  }
};

// ---- Around one disparity

// The columns of the right image that each pixel of a row is compared with. Taps differ by whole
// columns, so that the 2 radius + 1 taps share 2 radius + 2 columns and the weight between two.
struct LocalColumns {
  int64_t count, margin;
  std::vector<int64_t> first;  // Within a row that has `margin` zeros at either end.
  std::vector<float> second_weight;

  LocalColumns(const float* disparity, int64_t width, int64_t radius)
      : count(2 * radius + 2), margin(count) {
    for (int64_t x = 0; x < width; ++x) {
      const float at = static_cast<float>(x) - disparity[x], floor = std::floor(at);
      // Further outside there are only zeros as well.
      const float reached = std::min(static_cast<float>(width + radius),
                                     std::max(static_cast<float>(-radius - 2), floor));
      first.push_back(static_cast<int64_t>(reached) - radius + margin);
      second_weight.push_back(at - floor);
    }
  }
};

struct LocalFunction : public torch::autograd::Function<LocalFunction> {
  static Tensor forward(AutogradContext* context, const Tensor& left_in, const Tensor& right_in,
                        const Tensor& disparity_in, int64_t groups, int64_t radius) {
    const Tensor left = left_in.contiguous(), right = right_in.contiguous();
    const Tensor disparity = disparity_in.contiguous();
    context->save_for_backward({left, right, disparity});
    context->saved_data["groups"] = groups;
    context->saved_data["radius"] = radius;
    const Shape in = ShapeOf(left), one{in.batch, 1, in.height, in.width};
    const int64_t taps = 2 * radius + 1, in_group = in.channels / groups;
    const Shape out_shape{in.batch, groups * taps, in.height, in.width};
    Tensor result = torch::empty({in.batch, groups * taps, in.height, in.width}, left.options());
    const float *l = left.data_ptr<float>(), *r = right.data_ptr<float>(),
                *d = disparity.data_ptr<float>();
    float* out = result.data_ptr<float>();
    ForEachRow(in, [&](int64_t n, int64_t y) {
      const LocalColumns columns(d + one.Row(n, 0, y), in.width, radius);
      std::vector<float> padded(static_cast<size_t>(in.width + 2 * columns.margin));
      std::vector<float> sums(static_cast<size_t>(in.width * columns.count));
      for (int64_t g = 0; g < groups; ++g) {
        std::fill(sums.begin(), sums.end(), 0.0f);
        for (int64_t c = g * in_group; c < (g + 1) * in_group; ++c) {
          const float* lrow = l + in.Row(n, c, y);
          std::copy_n(r + in.Row(n, c, y), in.width, padded.begin() + columns.margin);
          ForEachColumn(columns, [&](size_t x, size_t sum, size_t column) {
            sums[sum] += lrow[x] * padded[column];
          });
        }
        for (int64_t t = 0; t < taps; ++t) {
          float* row = out + out_shape.Row(n, g * taps + t, y);
          for (int64_t x = 0; x < in.width; ++x) {
            const float weight = columns.second_weight[static_cast<size_t>(x)];
            const float* sum = &sums[static_cast<size_t>(x * columns.count + 2 * radius - t)];
            row[x] = (1 - weight) * sum[0] + weight * sum[1];
          }
        }
      }
    });
    return result;
  }

  static tensor_list backward(AutogradContext* context, tensor_list gradients) {
    const auto saved = context->get_saved_variables();
    const Tensor &left = saved[0], &right = saved[1], gradient = gradients[0].contiguous();
    const int64_t groups = context->saved_data["groups"].toInt();
    const int64_t radius = context->saved_data["radius"].toInt();
    const Shape in = ShapeOf(left), out = ShapeOf(gradient), one{in.batch, 1, in.height, in.width};
    const int64_t taps = 2 * radius + 1, in_group = in.channels / groups;
    Tensor left_gradient = torch::zeros_like(left), right_gradient = torch::empty_like(right);
    const float *l = left.data_ptr<float>(), *r = right.data_ptr<float>(),
                *d = saved[2].data_ptr<float>(), *slopes = gradient.data_ptr<float>();
    float *lg = left_gradient.data_ptr<float>(), *rg = right_gradient.data_ptr<float>();
    ForEachRow(in, [&](int64_t n, int64_t y) {
      const LocalColumns columns(d + one.Row(n, 0, y), in.width, radius);
      std::vector<float> padded(static_cast<size_t>(in.width + 2 * columns.margin)),
          padded_gradient(padded.size());
      std::vector<float> sums(static_cast<size_t>(in.width * columns.count));  // Their gradients.
      for (int64_t g = 0; g < groups; ++g) {
        std::fill(sums.begin(), sums.end(), 0.0f);
        for (int64_t t = 0; t < taps; ++t) {
          const float* row = slopes + out.Row(n, g * taps + t, y);
          for (int64_t x = 0; x < in.width; ++x) {
            const float weight = columns.second_weight[static_cast<size_t>(x)];
            float* sum = &sums[static_cast<size_t>(x * columns.count + 2 * radius - t)];
            sum[0] += (1 - weight) * row[x];
            sum[1] += weight * row[x];
          }
        }
        for (int64_t c = g * in_group; c < (g + 1) * in_group; ++c) {
          const int64_t row = in.Row(n, c, y);
          std::copy_n(r + row, in.width, padded.begin() + columns.margin);
          std::fill(padded_gradient.begin(), padded_gradient.end(), 0.0f);
          ForEachColumn(columns, [&](size_t x, size_t sum, size_t column) {
            lg[row + static_cast<int64_t>(x)] += sums[sum] * padded[column];
            padded_gradient[column] += sums[sum] * l[row + static_cast<int64_t>(x)];
          });
          std::copy_n(padded_gradient.begin() + columns.margin, in.width, rg + row);
        }
      }
    });
    return {left_gradient, right_gradient, Tensor(), Tensor(), Tensor()};
  }

 private:
  // Calls `fn(x, index of x's sum with a column, index of the column)` for all sums of a row.
  template <typename Fn>
  static void ForEachColumn(const LocalColumns& columns, Fn fn) {
    const auto run = [&](auto count_in) {  // A constant count becomes vector instructions.
      const size_t count = static_cast<size_t>(count_in);
      for (size_t x = 0; x < columns.first.size(); ++x) {
        const auto first = static_cast<size_t>(columns.first[x]);
        for (size_t j = 0; j < count; ++j) fn(x, x * count + j, first + j);
      }
    };
    if (columns.count == 8) {
      run(std::integral_constant<int64_t, 8>());
    } else {
      run(columns.count);
    }
  }
};

}  // namespace

Tensor CorrelationVolume(const Tensor& left, const Tensor& right, int64_t groups,
                         int64_t disparities) {
  return VolumeFunction::apply(left, right, groups, disparities);
}

Tensor LocalCorrelation(const Tensor& left, const Tensor& right, const Tensor& disparity,
                        int64_t groups, int64_t radius) {
  return LocalFunction::apply(left, right, disparity, groups, radius);
}

}  // namespace parallax
