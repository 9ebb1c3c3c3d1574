#include "worker/terrain/erosion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/base/rng.h"
#include "worker/materials/kernel/noise.h"
#include "worker/terrain/flow.h"

namespace parallax {
namespace {

constexpr float kKilometre = 1e3f, kSquareKilometre = 1e6f;

// One implicit step: from the outlets upstream, each sample takes a height between its own and that
// of its receiver, and no slope stays steeper than its `talus`.
void CutStreams(Field& height, const Field& talus, const StreamPowerOptions& options) {
  const FlowGraph flow = RouteFlow(height);
  const Field area = DrainageArea(height, flow);
  height.values = flow.filled;
  const auto n = static_cast<uint32_t>(height.size);
  for (const uint32_t sample : flow.order) {
    const uint32_t receiver = flow.receivers[sample];
    if (receiver == sample) continue;
    const bool diagonal = sample % n != receiver % n && sample / n != receiver / n;
    const float run_m = height.cell_m * (diagonal ? std::numbers::sqrt2_v<float> : 1.0f);
    const float power = options.erodibility *
                        std::pow(area.values[sample] / kSquareKilometre, options.area_exponent);
    const float step = power * kKilometre / run_m;
    const float below = height.values[receiver];
    float& own = height.values[sample];
    if (own <= below) continue;
    own = std::min((own + step * below) / (1 + step), below + talus.values[sample] * run_m);
  }
}

// Soil creep: each sample moves towards the mean of its four neighbours.
void Creep(Field& height, float share) {
  const int n = height.size;
  std::vector<float> above(height.values.begin(), height.values.begin() + n), own = above;
  for (int row = 1; row < n - 1; ++row) {
    std::copy_n(&height.values[height.Index(0, row)], n, own.begin());
    for (int column = 1; column < n - 1; ++column) {
      const auto c = static_cast<size_t>(column);
      const float mean = 0.25f * (own[c - 1] + own[c + 1] + above[c] + height.At(column, row + 1));
      height.At(column, row) = own[c] + share * (mean - own[c]);
    }
    above.swap(own);
  }
}

// Rock differs from place to place: the slope that hillsides keep, in patches of many sizes.
Field TalusField(const Field& raster, const StreamPowerOptions& options) {
  Field talus = raster;
  ForRows(raster, [&](int row) {
    for (int column = 0; column < raster.size; ++column) {
      const Vec2f p = raster.PositionOf(column, row);
      const float patches =
          noise::Fbm3(Vec3f(p.x(), p.y(), 0.37f * p.x() - 0.29f * p.y()), 30 * raster.cell_m, 5,
                      0.5f * raster.cell_m, options.seed, 0.8f);
      talus.At(column, row) = options.talus * std::clamp(1 + 0.8f * patches, 0.25f, 1.9f);
    }
  });
  return talus;
}

// The border is the sea that everything drains to: it does not rise, and the land rises up to full
// within some samples.
void LeaveBorder(Field& uplift) {
  constexpr int kBand = 12;
  const int n = uplift.size;
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column < n; ++column) {
      const int inside = std::min({column, row, n - 1 - column, n - 1 - row});
      uplift.At(column, row) *= noise::SmoothStep(0, kBand, static_cast<float>(inside));
    }
  }
}

float Relief(const Field& height) { return Quantile(height, 0.95f) - Quantile(height, 0.05f); }

// ---- Droplets

// The cells about a point with weights that sum to 1 and fall off linearly.
constexpr int kBrushRadius = 2;
struct BrushCell {
  int dx, dy;
  float weight;
};

std::vector<BrushCell> MakeBrush() {
  std::vector<BrushCell> brush;
  float total = 0;
  for (int dy = -kBrushRadius; dy <= kBrushRadius; ++dy) {
    for (int dx = -kBrushRadius; dx <= kBrushRadius; ++dx) {
      const float distance = std::sqrt(static_cast<float>(dx * dx + dy * dy));
      const float weight = kBrushRadius + 0.5f - distance;
      if (weight <= 0) continue;
      brush.push_back({dx, dy, weight});
      total += weight;
    }
  }
  for (BrushCell& cell : brush) cell.weight /= total;
  return brush;
}

class Rain {
 public:
  Rain(Field& height, Field& deposit, const DropletOptions& options)
      : height_(height), deposit_(deposit), options_(options), brush_(MakeBrush()) {}

  void RunDrop(Rng& rng);

 private:
  // Height and slope (a cell) at a position in cells, bilinear.
  struct Look {
    float height;
    Vec2f slope;
  };
  Look LookAt(const Vec2f& p) const;
  bool Inside(const Vec2f& p) const {
    const float end = static_cast<float>(height_.size - kBrushRadius - 2);
    return p.minCoeff() > kBrushRadius + 1 && p.maxCoeff() < end;
  }
  void LayDown(const Vec2f& p, float amount);
  void TakeUp(const Vec2f& p, float amount);

  Field& height_;
  Field& deposit_;
  const DropletOptions& options_;
  const std::vector<BrushCell> brush_;
};

Rain::Look Rain::LookAt(const Vec2f& p) const {
  const int x = static_cast<int>(p.x()), y = static_cast<int>(p.y());
  const float u = p.x() - static_cast<float>(x), v = p.y() - static_cast<float>(y);
  const float a = height_.At(x, y), b = height_.At(x + 1, y), c = height_.At(x, y + 1),
              d = height_.At(x + 1, y + 1);
  return {a * (1 - u) * (1 - v) + b * u * (1 - v) + c * (1 - u) * v + d * u * v,
          Vec2f((b - a) * (1 - v) + (d - c) * v, (c - a) * (1 - u) + (d - b) * u)};
}

void Rain::LayDown(const Vec2f& p, float amount) {
  const int x = static_cast<int>(p.x()), y = static_cast<int>(p.y());
  const float u = p.x() - static_cast<float>(x), v = p.y() - static_cast<float>(y);
  const std::array<float, 4> shares = {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
  for (int k = 0; k < 4; ++k) {
    const float share = amount * shares[static_cast<size_t>(k)];
    height_.At(x + k % 2, y + k / 2) += share;
    deposit_.At(x + k % 2, y + k / 2) += share;
  }
}

void Rain::TakeUp(const Vec2f& p, float amount) {
  const int x = static_cast<int>(p.x() + 0.5f), y = static_cast<int>(p.y() + 0.5f);
  for (const BrushCell& cell : brush_) {
    height_.At(x + cell.dx, y + cell.dy) -= amount * cell.weight;
  }
}

void Rain::RunDrop(Rng& rng) {
  const float last = static_cast<float>(height_.size - 1);
  Vec2f p(static_cast<float>(rng.Uniform()) * last, static_cast<float>(rng.Uniform()) * last);
  Vec2f direction = Vec2f::Zero();
  float water = 1, sediment = 0;
  for (int i = 0; i < options_.lifetime && Inside(p); ++i) {
    const Look here = LookAt(p);
    direction = options_.inertia * direction - (1 - options_.inertia) * here.slope;
    const float length = direction.norm();
    if (length < 1e-6f) break;
    direction /= length;
    const Vec2f next = p + direction;
    if (!Inside(next)) break;

    const float fall = here.height - LookAt(next).height;
    if (fall <= 0) {
      // Uphill: fills the hollow behind it as far as its sediment goes.
      const float amount = std::min(sediment, -fall + 1e-3f);
      LayDown(p, amount);
      sediment -= amount;
      if (sediment <= 0) break;
    } else {
      const float capacity = options_.capacity * fall * water;
      if (sediment > capacity) {
        const float amount = (sediment - capacity) * options_.deposition;
        LayDown(p, amount);
        sediment -= amount;
      } else {
        const float amount = std::min((capacity - sediment) * options_.erosion, fall);
        TakeUp(p, amount);
        sediment += amount;
      }
    }
    water *= 1 - options_.evaporation;
    p = next;
  }
  if (sediment > 0 && Inside(p)) LayDown(p, sediment);
}

}  // namespace

void ErodeByStreams(Field& height, const StreamPowerOptions& options) {
  const float wanted = Relief(height);
  if (options.steps <= 0 || wanted <= 0) return;
  // The land rises where it stood high; what it was at first only says where the first drops run.
  const FieldRange range = RangeOf(height);
  Field uplift = height;
  for (float& value : uplift.values) {
    value = 0.15f + (value - range.low) / (range.high - range.low);
  }
  for (float& value : height.values) value = 0.1f * (value - range.low);
  LeaveBorder(uplift);
  const Field talus = TalusField(height, options);
  float rise_m = wanted / static_cast<float>(options.steps);
  for (int step = 0; step < options.steps; ++step) {
    for (size_t i = 0; i < height.values.size(); ++i) {
      height.values[i] += rise_m * uplift.values[i];
    }
    CutStreams(height, talus, options);
    Creep(height, options.diffusion);
    rise_m *= std::clamp(wanted / std::max(Relief(height), 1e-3f * wanted), 0.8f, 1.25f);
  }
  const float low = RangeOf(height).low;
  for (float& value : height.values) value += range.low - low;
}

void ErodeByDroplets(Field& height, Field& deposit, const DropletOptions& options) {
  Rain rain(height, deposit, options);
  Rng rng(SceneSeed{options.seed}, "droplets");
  for (int i = 0; i < options.droplets; ++i) rain.RunDrop(rng);
}

void ErodeByGravity(Field& height, Field& deposit, const ThermalOptions& options) {
  const int n = height.size;
  constexpr std::array<std::array<int, 2>, 8> kSteps = {
      {{1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
  // A slide takes from its sample what it gives to the lowest one beside it.
  struct Slide {
    size_t lowest = 0;
    float amount = 0;
  };
  std::vector<Slide> slides(height.values.size());
  std::vector<float> change(height.values.size());
  for (int pass = 0; pass < options.passes; ++pass) {
    std::fill(change.begin(), change.end(), 0.0f);
    ForRows(height, [&](int row) {
      if (row == 0 || row == n - 1) return;
      for (int column = 1; column < n - 1; ++column) {
        const size_t here = height.Index(column, row);
        const float own = height.values[here];
        slides[here] = {};
        // The steepest way down.
        float fall = 0, run_m = height.cell_m;
        size_t lowest = here;
        for (const auto& [dx, dy] : kSteps) {
          const size_t other = height.Index(column + dx, row + dy);
          const float distance =
              height.cell_m * (dx != 0 && dy != 0 ? std::numbers::sqrt2_v<float> : 1.0f);
          if ((own - height.values[other]) * run_m <= fall * distance) continue;
          fall = own - height.values[other];
          run_m = distance;
          lowest = other;
        }
        if (fall <= options.talus * run_m) continue;

        // Rock is banded by height: a hard band stands as a cliff over the scree of a soft one.
        const Vec2f p = height.PositionOf(column, row);
        const float band =
            noise::Gradient3(p.x() / 300, p.y() / 300, own / options.band_m, options.seed);
        const float hardness = noise::Lerp(options.hardness_low, options.hardness_high,
                                           noise::SmoothStep(-0.25f, 0.35f, band));
        const float excess = fall - options.talus * std::max(1.0f, hardness) * run_m;
        if (excess <= 0) continue;
        slides[here] = {lowest, 0.25f * excess};
      }
    });
    // Slides are added in their order, because sums depend on it.
    for (size_t i = 0; i < slides.size(); ++i) {
      if (slides[i].amount <= 0) continue;
      change[i] -= slides[i].amount;
      change[slides[i].lowest] += slides[i].amount;
    }
    for (size_t i = 0; i < change.size(); ++i) {
      height.values[i] += change[i];
      deposit.values[i] = std::max(0.0f, deposit.values[i] + change[i]);
    }
  }
}

}  // namespace parallax
