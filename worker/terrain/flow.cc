#include "worker/terrain/flow.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "worker/materials/kernel/noise.h"

namespace parallax {
namespace {

struct Neighbour {
  int dx, dy;
  float distance;  // In cells.
};
constexpr float kDiagonal = std::numbers::sqrt2_v<float>;
constexpr std::array<Neighbour, 8> kNeighbours = {{{1, 0, 1},
                                                   {0, 1, 1},
                                                   {-1, 0, 1},
                                                   {0, -1, 1},
                                                   {1, 1, kDiagonal},
                                                   {-1, 1, kDiagonal},
                                                   {-1, -1, kDiagonal},
                                                   {1, -1, kDiagonal}}};

// A priority queue whose lowest key never falls: buckets of equal (rounded) height, each a list
// threaded through `next_`, first in first out.
class BucketQueue {
 public:
  BucketQueue(FieldRange range, size_t samples)
      : low_(range.low),
        scale_(range.high > range.low ? kBuckets / (range.high - range.low) : 0.0f),
        heads_(kBuckets + 1, kNone),
        tails_(kBuckets + 1, kNone),
        next_(samples, kNone) {}

  void Push(uint32_t sample, float height) {
    const size_t bucket = std::max(
        bucket_, static_cast<size_t>(std::clamp((height - low_) * scale_, 0.0f, kBuckets * 1.0f)));
    if (heads_[bucket] == kNone) {
      heads_[bucket] = sample;
    } else {
      next_[tails_[bucket]] = sample;
    }
    tails_[bucket] = sample;
  }
  // False when the queue is empty.
  bool Pop(uint32_t& sample) {
    while (heads_[bucket_] == kNone) {
      if (bucket_ == kBuckets) return false;
      ++bucket_;
    }
    sample = heads_[bucket_];
    heads_[bucket_] = next_[sample];
    return true;
  }

 private:
  static constexpr size_t kBuckets = 1 << 16;
  static constexpr uint32_t kNone = UINT32_MAX;

  const float low_, scale_;
  std::vector<uint32_t> heads_, tails_, next_;
  size_t bucket_ = 0;
};

// A number in [0, 1) for each pair of neighbours. Ground is never even: it keeps flow from running
// in the raster's eight directions.
float Chance(uint32_t from, uint32_t to) {
  return noise::Unit(noise::Hash(static_cast<int32_t>(from), to * 0x9e3779b9u));
}
// A hollow is filled to a fan that rises by up to this slope away from its spill.
constexpr float kFanSlope = 0.006f;

}  // namespace

FlowGraph RouteFlow(const Field& height) {
  const int n = height.size;
  const size_t count = height.values.size();
  FlowGraph flow;
  flow.receivers.resize(count);
  flow.order.reserve(count);
  flow.filled = height.values;
  BucketQueue queue(RangeOf(height), count);
  enum : uint8_t { kUnseen, kQueued, kDrained };
  std::vector<uint8_t> state(count, kUnseen);

  // Water leaves at the border.
  for (uint32_t i = 0; i < count; ++i) {
    const int column = static_cast<int>(i) % n, row = static_cast<int>(i) / n;
    if (column > 0 && row > 0 && column < n - 1 && row < n - 1) continue;
    flow.receivers[i] = i;
    state[i] = kQueued;
    queue.Push(i, height.values[i]);
  }

  // The flood rises inwards. A sample drains to its steepest neighbour that is drained already, or
  // to the one that flooded it.
  uint32_t sample;
  while (queue.Pop(sample)) {
    const int column = static_cast<int>(sample) % n, row = static_cast<int>(sample) / n;
    const bool outlet = flow.receivers[sample] == sample;
    float steepest = 0;
    for (const Neighbour& step : kNeighbours) {
      const int x = column + step.dx, y = row + step.dy;
      if (x < 0 || y < 0 || x >= n || y >= n) continue;
      const uint32_t other = static_cast<uint32_t>(height.Index(x, y));
      if (state[other] == kUnseen) {
        flow.receivers[other] = sample;
        const float fan_m = kFanSlope * height.cell_m * step.distance * Chance(sample, other);
        flow.filled[other] = std::max(flow.filled[other], flow.filled[sample] + fan_m);
        state[other] = kQueued;
        queue.Push(other, flow.filled[other]);
      } else if (state[other] == kDrained && !outlet) {
        const float slope = (flow.filled[sample] - flow.filled[other]) / step.distance *
                            (0.5f + Chance(sample, other));
        if (slope > steepest) {
          steepest = slope;
          flow.receivers[sample] = other;
        }
      }
    }
    state[sample] = kDrained;
    flow.order.push_back(sample);
  }
  return flow;
}

Field DrainageArea(const Field& height, const FlowGraph& flow) {
  Field area = height;
  std::fill(area.values.begin(), area.values.end(), height.cell_m * height.cell_m);
  for (size_t k = flow.order.size(); k-- > 0;) {
    const uint32_t sample = flow.order[k], receiver = flow.receivers[sample];
    if (receiver != sample) area.values[receiver] += area.values[sample];
  }
  return area;
}

Field Wetness(const Field& height, const Field& drainage_area) {
  Field wetness = height;
  const int n = height.size;
  ForRows(height, [&](int row) {
    for (int column = 0; column < n; ++column) {
      const auto at = [&](int x, int y) {
        return height.At(std::clamp(x, 0, n - 1), std::clamp(y, 0, n - 1));
      };
      const Vec2f slope = Vec2f(at(column + 1, row) - at(column - 1, row),
                                at(column, row + 1) - at(column, row - 1)) /
                          (2 * height.cell_m);
      wetness.At(column, row) =
          std::log(drainage_area.At(column, row) / (height.cell_m * std::max(slope.norm(), 0.01f)));
    }
  });
  const float low = Quantile(wetness, 0.02f), high = Quantile(wetness, 0.98f);
  const float scale = high > low ? 1.0f / (high - low) : 0.0f;
  for (float& value : wetness.values) value = std::clamp((value - low) * scale, 0.0f, 1.0f);
  return wetness;
}

}  // namespace parallax
