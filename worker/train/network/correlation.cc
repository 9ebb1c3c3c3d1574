#include "worker/train/network/correlation.h"

#include <ATen/Parallel.h>
#include <torch/csrc/autograd/custom_function.h>

#include <cmath>
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

// Column x - disparity - r of the right image as the two columns around it and the second's weight.
struct Columns {
  int64_t first;
  float second_weight;
  Columns(int64_t x, float disparity, int64_t r) {
    const float at = static_cast<float>(x - r) - disparity;
    const float floor = std::floor(at);
    first = static_cast<int64_t>(floor);
    second_weight = at - floor;
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
    const Shape in = ShapeOf(left);
    const Shape out_shape{in.batch, groups * (2 * radius + 1), in.height, in.width};
    Tensor result =
        torch::zeros({out_shape.batch, out_shape.channels, in.height, in.width}, left.options());
    float* out = result.data_ptr<float>();
    ForEachTap(left, right, disparity, groups, radius, [&](const Tap& tap) {
      float sum = 0;
      if (tap.first_inside) sum += (1 - tap.weight) * tap.left * tap.right[tap.first];
      if (tap.second_inside) sum += tap.weight * tap.left * tap.right[tap.first + 1];
      out[out_shape.Row(tap.n, tap.channel, tap.y) + tap.x] += sum;
    });
    return result;
  }

  static tensor_list backward(AutogradContext* context, tensor_list gradients) {
    const auto saved = context->get_saved_variables();
    const Tensor &left = saved[0], &right = saved[1], gradient = gradients[0].contiguous();
    const int64_t groups = context->saved_data["groups"].toInt();
    const int64_t radius = context->saved_data["radius"].toInt();
    const Shape in = ShapeOf(left), out = ShapeOf(gradient);
    Tensor left_gradient = torch::zeros_like(left), right_gradient = torch::zeros_like(right);
    const float* g = gradient.data_ptr<float>();
    float *lg = left_gradient.data_ptr<float>(), *rg = right_gradient.data_ptr<float>();
    ForEachTap(left, right, saved[2], groups, radius, [&](const Tap& tap) {
      const float slope = g[out.Row(tap.n, tap.channel, tap.y) + tap.x];
      const int64_t row = in.Row(tap.n, tap.c, tap.y);
      if (tap.first_inside) {
        lg[row + tap.x] += slope * (1 - tap.weight) * tap.right[tap.first];
        rg[row + tap.first] += slope * (1 - tap.weight) * tap.left;
      }
      if (tap.second_inside) {
        lg[row + tap.x] += slope * tap.weight * tap.right[tap.first + 1];
        rg[row + tap.first + 1] += slope * tap.weight * tap.left;
      }
    });
    return {left_gradient, right_gradient, Tensor(), Tensor(), Tensor()};
  }

 private:
  // One product of the sum: channel `c` of pixel (x, y) of image `n` for output `channel`.
  struct Tap {
    int64_t n, y, c, x, channel, first;
    float weight, left;
    const float* right;  // The row.
    bool first_inside, second_inside;
  };

  template <typename TapFn>
  static void ForEachTap(const Tensor& left, const Tensor& right, const Tensor& disparity,
                         int64_t groups, int64_t radius, TapFn tap_fn) {
    const Shape in = ShapeOf(left);
    const Shape one{in.batch, 1, in.height, in.width};
    const int64_t in_group = in.channels / groups, taps = 2 * radius + 1;
    const float *l = left.data_ptr<float>(), *r = right.data_ptr<float>(),
                *d = disparity.data_ptr<float>();
    ForEachRow(in, [&](int64_t n, int64_t y) {
      const float* drow = d + one.Row(n, 0, y);
      for (int64_t c = 0; c < in.channels; ++c) {
        const float *lrow = l + in.Row(n, c, y), *rrow = r + in.Row(n, c, y);
        for (int64_t t = 0; t < taps; ++t) {
          for (int64_t x = 0; x < in.width; ++x) {
            const Columns columns(x, drow[x], t - radius);
            tap_fn(Tap{n, y, c, x, c / in_group * taps + t, columns.first, columns.second_weight,
                       lrow[x], rrow, columns.first >= 0 && columns.first < in.width,
                       columns.first + 1 >= 0 && columns.first + 1 < in.width});
          }
        }
      }
    });
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
