#include "worker/train/network/group_norm.h"

#include <ATen/Parallel.h>
#include <torch/csrc/autograd/custom_function.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

namespace parallax {
namespace {

using torch::Tensor;
using torch::autograd::AutogradContext;
using torch::autograd::tensor_list;

constexpr double kVarianceFloor = 1e-5;

// Bits of bfloat16; c10::BFloat16 itself is not computed with in vectors.
using Half = uint16_t;

float Wide(Half bits) { return std::bit_cast<float>(static_cast<uint32_t>(bits) << 16); }

Half Narrow(float value) {  // Rounds to the nearest, ties to even.
  const auto bits = std::bit_cast<uint32_t>(value);
  return static_cast<Half>((bits + 0x7fff + (bits >> 16 & 1)) >> 16);
}

// The slope that ReLU passes back where its result has bits.
float Passed(Half slope, Half result) {
  return Wide(static_cast<Half>(slope & (result == 0 ? 0 : 0xffff)));
}

// Memory as rows whose lanes are channels: all of them with channels last, else eight times the
// same one. A plane is what one image, or one of its channels, occupies.
struct Planes {
  int64_t images, channels, pixels;
  bool last;

  explicit Planes(const Tensor& t)
      : images(t.size(0)),
        channels(t.size(1)),
        pixels(t.numel() / (t.size(0) * t.size(1))),
        last(t.dim() == 4) {}

  torch::MemoryFormat format() const {
    return last ? torch::MemoryFormat::ChannelsLast : torch::MemoryFormat::Contiguous;
  }

  // Calls `plane(offset, rows, lanes, channel)` for each plane of an image.
  template <typename PlaneFn>
  void ForEach(int64_t image, PlaneFn plane) const {
    const int64_t start = image * channels * pixels;
    if (last) return plane(start, pixels, channels, 0);
    for (int64_t c = 0; c < channels; ++c) plane(start + c * pixels, pixels / 8, 8, c);
  }
};

using Floats = std::vector<float>;

// Two sums for each channel of an image. `add_row(start, lanes, first, second)` adds a row's lanes
// to both; rows are summed in short blocks, so that float32 is enough.
template <typename AddRowFn>
void SumChannels(const Planes& planes, int64_t image, Floats& first, Floats& second,
                 AddRowFn add_row) {
  constexpr int64_t kBlock = 32;
  planes.ForEach(image, [&](int64_t start, int64_t rows, int64_t lanes, int64_t channel) {
    const auto count = static_cast<size_t>(lanes);
    Floats a(count), b(count), block_a(count), block_b(count);
    for (int64_t row = 0; row < rows; row += kBlock) {
      std::fill(block_a.begin(), block_a.end(), 0.0f);
      std::fill(block_b.begin(), block_b.end(), 0.0f);
      for (int64_t r = row; r < std::min(rows, row + kBlock); ++r) {
        add_row(start + r * lanes, lanes, block_a.data(), block_b.data());
      }
      for (size_t i = 0; i < count; ++i) {
        a[i] += block_a[i];
        b[i] += block_b[i];
      }
    }
    for (size_t i = 0; i < count; ++i) {
      const size_t to = planes.last ? i : static_cast<size_t>(channel);
      first[to] += a[i];
      second[to] += b[i];
    }
  });
}

// Calls `fill_row(start, lanes, tables)` for each row of an image; `tables` has the channel's
// values for each lane.
template <typename FillRowFn>
void FillChannels(const Planes& planes, int64_t image, const std::array<Floats, 3>& tables,
                  FillRowFn fill_row) {
  planes.ForEach(image, [&](int64_t start, int64_t rows, int64_t lanes, int64_t channel) {
    std::array<Floats, 3> spread = tables;
    for (Floats& table : spread) {
      if (planes.last || table.empty()) continue;
      const float value = table[static_cast<size_t>(channel)];
      table.assign(8, value);
    }
    const std::array<const float*, 3> rows_of = {spread[0].data(), spread[1].data(),
                                                 spread[2].data()};
    for (int64_t r = 0; r < rows; ++r) fill_row(start + r * lanes, lanes, rows_of);
  });
}

const Half* Bits(const Tensor& t) { return reinterpret_cast<const Half*>(t.data_ptr()); }

struct GroupNormReluFunction : public torch::autograd::Function<GroupNormReluFunction> {
  static Tensor forward(AutogradContext* context, const Tensor& t_in, const Tensor& scale,
                        const Tensor& shift) {
    const Planes planes(t_in);
    const Tensor t = t_in.contiguous(planes.format());
    Tensor result = torch::empty_like(t);
    // For each image and channel: mean and 1 / deviation of its group.
    Tensor moments = torch::empty({2, planes.images, planes.channels});
    const Half* x = Bits(t);
    Half* out = reinterpret_cast<Half*>(result.data_ptr());
    const float *g = scale.data_ptr<float>(), *b = shift.data_ptr<float>();
    const auto channels = static_cast<size_t>(planes.channels);
    at::parallel_for(0, planes.images, 1, [&](int64_t begin, int64_t end) {
      for (int64_t image = begin; image < end; ++image) {
        Floats sums(channels), squares(channels), factor(channels), offset(channels);
        SumChannels(
            planes, image, sums, squares,
            [&](int64_t at, int64_t lanes, float* __restrict sum, float* __restrict square) {
              for (int64_t i = 0; i < lanes; ++i) {
                const float value = Wide(x[at + i]);
                sum[i] += value;
                square[i] += value * value;
              }
            });
        float* mean = moments.data_ptr<float>() + image * planes.channels;
        float* slope = mean + planes.images * planes.channels;
        for (size_t first = 0; first < channels; first += kChannelsInGroup) {
          double sum = 0, square = 0;
          for (size_t c = first; c < first + kChannelsInGroup; ++c) {
            sum += sums[c];
            square += squares[c];
          }
          const double count = static_cast<double>(kChannelsInGroup * planes.pixels);
          const double centre = sum / count;
          const double variance = std::max(0.0, square / count - centre * centre);
          for (size_t c = first; c < first + kChannelsInGroup; ++c) {
            mean[c] = static_cast<float>(centre);
            slope[c] = static_cast<float>(1 / std::sqrt(variance + kVarianceFloor));
            factor[c] = slope[c] * g[c];
            offset[c] = b[c] - mean[c] * factor[c];
          }
        }
        FillChannels(planes, image, {factor, offset, {}},
                     [&](int64_t at, int64_t lanes, const auto& tables) {
                       const float *scales = tables[0], *shifts = tables[1];
                       Half* __restrict to = out + at;
                       for (int64_t i = 0; i < lanes; ++i) {
                         const float value = Wide(x[at + i]) * scales[i] + shifts[i];
                         to[i] = Narrow(value < 0 ? 0.0f : value);  // NaN stays.
                       }
                     });
      }
    });
    context->save_for_backward({t, result, scale, moments});
    return result;
  }

  static tensor_list backward(AutogradContext* context, tensor_list gradients) {
    const auto saved = context->get_saved_variables();
    const Planes planes(saved[0]);
    const Tensor gradient = gradients[0].contiguous(planes.format());
    Tensor result = torch::empty_like(saved[0]);
    const auto channels = static_cast<size_t>(planes.channels);
    Tensor of_scale = torch::empty({planes.images, planes.channels}),
           of_shift = torch::empty({planes.images, planes.channels});
    const Half *x = Bits(saved[0]), *y = Bits(saved[1]), *slopes = Bits(gradient);
    const float* g = saved[2].data_ptr<float>();
    Half* out = reinterpret_cast<Half*>(result.data_ptr());
    at::parallel_for(0, planes.images, 1, [&](int64_t begin, int64_t end) {
      for (int64_t image = begin; image < end; ++image) {
        const float* mean = saved[3].data_ptr<float>() + image * planes.channels;
        const float* slope = mean + planes.images * planes.channels;
        float* scale_sum = of_scale.data_ptr<float>() + image * planes.channels;
        float* shift_sum = of_shift.data_ptr<float>() + image * planes.channels;
        Floats sums(channels), products(channels), factor(channels), linear(channels),
            offset(channels);
        SumChannels(
            planes, image, sums, products,
            [&](int64_t at, int64_t lanes, float* __restrict sum, float* __restrict product) {
              for (int64_t i = 0; i < lanes; ++i) {
                const float value = Passed(slopes[at + i], y[at + i]);
                sum[i] += value;
                product[i] += value * Wide(x[at + i]);
              }
            });
        for (size_t first = 0; first < channels; first += kChannelsInGroup) {
          double plain = 0, along = 0;  // Sums of slopes, and of slopes times normalised values.
          for (size_t c = first; c < first + kChannelsInGroup; ++c) {
            shift_sum[c] = sums[c];
            scale_sum[c] = slope[c] * (products[c] - mean[c] * sums[c]);
            plain += g[c] * shift_sum[c];
            along += g[c] * scale_sum[c];
          }
          const double count = static_cast<double>(kChannelsInGroup * planes.pixels);
          for (size_t c = first; c < first + kChannelsInGroup; ++c) {
            factor[c] = slope[c] * g[c];
            linear[c] = static_cast<float>(-along / count) * slope[c] * slope[c];
            offset[c] = static_cast<float>(-plain / count) * slope[c] - mean[c] * linear[c];
          }
        }
        FillChannels(planes, image, {factor, linear, offset},
                     [&](int64_t at, int64_t lanes, const auto& tables) {
                       const float *factors = tables[0], *lines = tables[1], *shifts = tables[2];
                       Half* __restrict to = out + at;
                       for (int64_t i = 0; i < lanes; ++i) {
                         to[i] = Narrow(Passed(slopes[at + i], y[at + i]) * factors[i] +
                                        Wide(x[at + i]) * lines[i] + shifts[i]);
                       }
                     });
      }
    });
    return {result, of_scale.sum(0), of_shift.sum(0)};
  }
};

}  // namespace

Tensor GroupNormRelu(const Tensor& t, const Tensor& scale, const Tensor& shift) {
  return GroupNormReluFunction::apply(t, scale, shift);
}

}  // namespace parallax
