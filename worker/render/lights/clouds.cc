#include "worker/render/lights/clouds.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "worker/materials/kernel/noise.h"
#include "worker/render/surface/sampling.h"

namespace parallax {
namespace {

constexpr float kLow_km = 1.2f, kHigh_km = 2.4f, kStreaks_km = 8.0f;
constexpr float kEarth_km = 6371;
constexpr float kHeap_km = 2.6f;    // Size of cumulus and gaps.
constexpr float kDensity = 22.0f;   // Extinction inside, 1/km.
constexpr float kReach_km = 22.0f;  // Farther clouds fade into haze.
constexpr int kSteps = 12, kLowSteps = 48, kLightSteps = 4;
constexpr int kParts = 4;            // Number of parts of a step that is near a cloud.
constexpr float kOpaque = 0.01f;     // A ray ends where less than this share of light passes.
constexpr float kShadow_km = 0.12f;  // Detail finer than this casts no shadow.
constexpr float kLowSky = 0.3f;      // Sine of an elevation.
// Light that was scattered many times, alike in every direction: with it, a cloud in full sun is
// nearly as bright as a white board, and its base as what passes through that much cloud.
constexpr float kMany = 0.15f;

// Distance to a shell of this height above a round earth, from its ground.
Float8 DistanceTo(float height_km, Float8 z) {
  const Float8 along = kEarth_km * z;
  return Sqrt(along * along + 2.0f * kEarth_km * height_km + height_km * height_km) - along;
}

float HenyeyGreenstein(float cosine, float g) {
  const float d = 1.0f + g * g - 2.0f * g * cosine;
  return (1.0f - g * g) / (4.0f * kPi * d * std::sqrt(d));
}

// The density of clouds in the layers.
class Field {
 public:
  Field(double cover, uint64_t seed)
      : heaps_(static_cast<uint32_t>(seed ^ seed >> 32) * 2654435761u),
        detail_(heaps_ + 77),
        streaks_(heaps_ + 191) {
    // The value above which this share of the layer lies.
    std::vector<float> values;
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; x += kLanes) {
        Float8 at;
        for (int lane = 0; lane < kLanes; ++lane) at[lane] = 0.83f * static_cast<float>(x + lane);
        const Float8 form = Form(at, Splat(0.83f * static_cast<float>(y)));
        for (int lane = 0; lane < kLanes; ++lane) values.push_back(form[lane]);
      }
    }
    const auto rank = static_cast<size_t>(std::clamp(1.0 - cover, 0.0, 1.0) *
                                          static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(rank),
                     values.end());
    least_ = values[rank];
    most_ = *std::max_element(values.begin(), values.end());
  }

  // Density in [0, 1]; `height` in [0, 1] through the layer. Detail finer than `seen_km` is left
  // out.
  Float8 HeapsAt(Float8 x, Float8 y, Float8 height, Float8 seen_km) const {
    // Flat below, domed above: the higher above the threshold, the taller the cumulus.
    const Float8 rise = noise::Saturate((Form(x, y) - least_) / (most_ - least_ + 1e-3f));
    const Mask8 any = (rise > 0.0f) & (height >= 0.0f) & (height <= 1.0f);
    if (!Any(any)) return Splat(0);
    const Float8 top = Sqrt(rise * Sqrt(rise)) * 1.3f;
    const Float8 body = Min(height / 0.08f, (top - height) / 0.35f);
    // Round heads with creases between them, as on a cauliflower. They fade towards the edge of the
    // cloud, which would else cut them off as a wall does.
    const Vec3x8 at(x, y, height * (kHigh_km - kLow_km));
    Float8 heads = Splat(0);
    float size = 0.42f, part = 0.55f;
    for (uint32_t octave = 0; octave < 4; ++octave) {
      const Float8 fade = noise::Fade(size, seen_km);
      if (!Any(fade > 0.0f)) break;
      const Float8 value = noise::Gradient3(at * (1.0f / size), detail_ + octave);
      heads += part * fade * (2.0f * Abs(value) - 0.45f);
      size *= 0.47f;
      part *= 0.55f;
    }
    heads *= noise::Saturate(25.0f * rise);
    return any ? noise::Saturate(1.6f * (body + 1.6f * heads - 0.05f)) : Splat(0);
  }

  // Returns whether cumulus may lie within half a step of one of these places.
  bool Near(Float8 x, Float8 y) const { return Any(Form(x, y) > least_ - 0.15f); }

  // Thin streaks, combed along x.
  Float8 StreaksAt(Float8 x, Float8 y) const {
    const Vec3x8 at(0.035f * x + 0.012f * y, 0.16f * y, Splat(0.5f));
    Float8 sum = Splat(0);
    float scale = 1, part = 1;
    for (uint32_t octave = 0; octave < 5; ++octave) {
      sum += part * noise::Gradient3(at * scale, streaks_ + octave);
      scale *= 2.1f;
      part *= 0.6f;
    }
    return noise::Saturate(0.9f * (sum - 0.12f));
  }

 private:
  Float8 Form(Float8 x, Float8 y) const {
    const Vec3x8 at(x / kHeap_km, y / kHeap_km, Splat(0.37f));
    return noise::Gradient3(at * 0.31f, heaps_) * 0.7f + noise::Gradient3(at, heaps_ + 1) +
           0.45f * noise::Gradient3(at * 2.3f, heaps_ + 2) +
           0.2f * noise::Gradient3(at * 5.1f, heaps_ + 3);
  }

  uint32_t heaps_, detail_, streaks_;
  float least_ = 0, most_ = 1;
};

class Baker {
 public:
  Baker(double cover, uint64_t seed, const CloudLight& light)
      : field_(cover, seed), cover_(static_cast<float>(cover)), light_(light) {}

  // The clouds in eight directions, each for a texel that is `angle` wide, radians.
  Clouds::Layer8 Through(const Vec3x8& d, Float8 angle) const {
    const Float8 z = Max(d.z, 0.004f);
    const Float8 from = DistanceTo(kLow_km, z), to = DistanceTo(kHigh_km, z);
    const Float8 seen_km = angle * from;
    // Near the horizon a ray crosses the layer at length, through many clouds. In the last few
    // degrees it is followed through the lower part of the layer only. Where clouds are near, its
    // steps are short: neighbouring rows of texels begin hundreds of metres apart, and with steps
    // that let a cloud's side be met early or late, clouds had stripes.
    const int steps = Any(z < kLowSky) ? kLowSteps : kSteps;
    const Float8 step = Min((to - from) / static_cast<float>(steps), 0.35f);
    const Float8 part = step * (1.0f / kParts);
    const Float8 cosine = Inner(d, Vec3x8(light_.sun_direction));
    Float8 forward, wide;
    for (int lane = 0; lane < kLanes; ++lane) {
      forward[lane] = 0.65f * HenyeyGreenstein(cosine[lane], 0.75f) +
                      0.35f * HenyeyGreenstein(cosine[lane], -0.15f);
      wide[lane] = HenyeyGreenstein(cosine[lane], 0.2f);
    }
    Float8 kept = Splat(1);
    Vec3x8 sum = Vec3x8::Zero();
    for (int k = 0; k < steps * kParts && Any(kept > kOpaque); ++k) {
      if (k % kParts == 0) {  // A step begins; it is passed over if no cloud is near its middle.
        const Vec3x8 middle = d * (from + part * static_cast<float>(k + kParts / 2));
        if (!field_.Near(middle.x, middle.y)) {
          k += kParts - 1;
          continue;
        }
      }
      const Float8 inside = part * (static_cast<float>(k) + 0.5f);
      const Vec3x8 at = d * (from + inside);
      const Float8 height = inside / (to - from);
      const Float8 density = field_.HeapsAt(at.x, at.y, height, seen_km);
      if (!Any(density > 0.0f)) continue;
      const Float8 depth = Depth(at, height, Max(seen_km, kShadow_km));
      const Float8 near = 1.0f - Exp(-density * kDensity * part);
      const Float8 sun =
          forward * Exp(-depth) + wide * 0.85f * Exp(-0.22f * depth) + kMany * Exp(-0.09f * depth);
      const Float8 open = 0.35f + 0.65f * height;
      const Vec3x8 light = Vec3x8(light_.sun_irradiance) * sun +
                           Vec3x8(light_.sky) * (0.8f * open) +
                           Vec3x8(light_.ground) * (0.45f * (1.0f - height));
      sum = sum + light * (kept * near);
      kept *= 1.0f - near;
    }
    return Faded(AddStreaks(d, z, forward, {sum, kept}), from);
  }

 private:
  // Optical depth towards the sun.
  Float8 Depth(const Vec3x8& at, Float8 height, Float8 seen_km) const {
    const float rise = std::max(0.12f, light_.sun_direction.z());
    const Vec3f way = light_.sun_direction / rise;
    const float step_km = 0.11f;
    Float8 depth = Splat(0);
    for (int k = 1; k <= kLightSteps; ++k) {
      const float far = step_km * static_cast<float>(k) * std::min(1.0f, 1.6f * rise);
      depth += field_.HeapsAt(at.x + way.x() * far, at.y + way.y() * far,
                              height + far / (kHigh_km - kLow_km), seen_km);
    }
    return depth * (kDensity * step_km);
  }

  Clouds::Layer8 AddStreaks(const Vec3x8& d, Float8 z, Float8 forward, Clouds::Layer8 below) const {
    const Float8 distance = DistanceTo(kStreaks_km, z);
    const Vec3x8 at = d * distance;
    const Float8 thick = 0.5f * std::min(1.0f, 2 * cover_) * field_.StreaksAt(at.x, at.y);
    const Vec3x8 light =
        Vec3x8(light_.sun_irradiance) * (0.6f * forward + kMany) + Vec3x8(light_.sky) * 0.7f;
    return {below.radiance + light * (below.kept * thick), below.kept * (1.0f - thick)};
  }

  // Distant clouds fade into the haze before them, which has the clear sky's colour.
  Clouds::Layer8 Faded(const Clouds::Layer8& layer, Float8 distance) const {
    const Float8 seen = Exp(-distance / kReach_km);
    return {layer.radiance * seen, 1.0f - (1.0f - layer.kept) * seen};
  }

  Field field_;
  float cover_;
  const CloudLight& light_;
};

// Directions of eight texels in a row of the table, from column `x0` on: a stereographic map of the
// hemisphere.
Vec3x8 DirectionsOf(int x0, int row, int side) {
  Vec3x8 directions = Vec3x8::Zero();
  const auto n = static_cast<float>(side);
  const float y = 2 * (static_cast<float>(row) + 0.5f) / n - 1;
  for (int lane = 0; lane < kLanes; ++lane) {
    const float x = 2 * (static_cast<float>(x0 + lane) + 0.5f) / n - 1;
    const float r2 = std::min(x * x + y * y, 1.0f);
    const float z = (1 - r2) / (1 + r2);
    directions.Set(lane, Vec3f(x * (1 + z), y * (1 + z), z).normalized());
  }
  return directions;
}

// Returns the seed of clouds that let most of the sun through: `seed` itself, the first that
// follows from it, or the clearest of kMostSkies where none does. Without a sun it is `seed`.
uint64_t SeedWithSun(double cover, uint64_t seed, const CloudLight& light) {
  constexpr int kMostSkies = 24;
  constexpr float kMost = 0.8f;
  if (light.sun_irradiance.maxCoeff() <= 0.0f) return seed;
  uint64_t clearest = seed;
  float most = -1;
  for (int k = 0; k < kMostSkies && most < kMost; ++k) {
    const uint64_t one = seed + static_cast<uint64_t>(k) * 0x9e3779b97f4a7c15u;
    const Float8 angle = Splat(0.005f);
    const float kept = Baker(cover, one, light).Through(Vec3x8(light.sun_direction), angle).kept[0];
    if (kept <= most) continue;
    most = kept;
    clearest = one;
  }
  return clearest;
}

// Weights of the four texels around a position at share `t` between the second and the third.
void SplineWeights(Float8 t, Float8 weights[4]) {
  const Float8 u = 1.0f - t, t2 = t * t, u2 = u * u;
  weights[0] = u2 * u * (1.0f / 6);
  weights[1] = 2.0f / 3 - t2 + 0.5f * t2 * t;
  weights[2] = 2.0f / 3 - u2 + 0.5f * u2 * u;
  weights[3] = t2 * t * (1.0f / 6);
}

}  // namespace

std::shared_ptr<const Clouds> Clouds::Bake(double cover, uint64_t seed, const CloudLight& light) {
  auto clouds = std::make_shared<Clouds>();
  const Baker baker(cover, SeedWithSun(cover, seed, light), light);
  clouds->texels_.resize(size_t{4} * kSide * kSide);
  tbb::parallel_for(0, kSide, [&](int row) {
    // Beside the hemisphere nothing is ever looked up.
    const float y = static_cast<float>(row) + 0.5f - 0.5f * kSide;
    const float radius = 0.5f * kSide + 4;  // Texels.
    const float half = std::sqrt(std::max(0.0f, radius * radius - y * y));
    const int first = std::max(0, static_cast<int>(0.5f * kSide - half) / kLanes * kLanes);
    const int end = std::min(kSide, static_cast<int>(0.5f * kSide + half) + 1);
    for (int x0 = first; x0 < end; x0 += kLanes) {
      const Vec3x8 directions = DirectionsOf(x0, row, kSide);
      const Float8 angle = (1.0f + directions.z) * (2.0f / static_cast<float>(kSide));
      const Layer8 layer = baker.Through(directions, angle);
      for (int lane = 0; lane < kLanes; ++lane) {
        float* texel = &clouds->texels_[size_t{4} * static_cast<size_t>(row * kSide + x0 + lane)];
        for (int c = 0; c < 3; ++c) texel[c] = layer.radiance.Get(lane)[c];
        texel[3] = layer.kept[lane];
      }
    }
  });
  clouds->sun_kept_ = clouds->At(Vec3x8(light.sun_direction)).kept[0];
  return clouds;
}

Clouds::Layer8 Clouds::At(const Vec3x8& directions) const {
  const Float8 z = Max(directions.z, 0.0f);
  const Float8 level = Sqrt(Max(directions.x * directions.x + directions.y * directions.y, 1e-6f));
  const Float8 scale = (0.5f * kSide) / (directions.z < 0.0f ? level : 1.0f + z);
  // Uniform cubic B-splines: a texel covers some pixels of a picture, and its edges must not show.
  const auto place = [&](Float8 p) {
    return Clamp(p * scale + (0.5f * kSide - 0.5f), 1.0f, kSide - 2.001f);
  };
  const Float8 x = place(directions.x), y = place(directions.y);
  Float8 across[4], down[4];
  SplineWeights(x - Floor(x), across);
  SplineWeights(y - Floor(y), down);
  const Int8 first = 4 * ((ToInt(Floor(y)) - 1) * kSide + ToInt(Floor(x)) - 1);
  Float8 out[4];
  for (int c = 0; c < 4; ++c) {
    out[c] = Splat(0);
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column) {
        const Int8 at = first + 4 * (row * kSide + column);
        out[c] += down[row] * across[column] * Gather(texels_.data() + c, at);
      }
    }
    out[c] = Max(out[c], 0.0f);
  }
  out[3] = Min(out[3], 1.0f);
  return {{out[0], out[1], out[2]}, out[3]};
}

}  // namespace parallax
