#include "worker/terrain/water.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "common/base/rng.h"
#include "worker/materials/kernel/noise.h"
#include "worker/terrain/plane_noise.h"

namespace parallax {
namespace {

constexpr float kTurn = 2 * std::numbers::pi_v<float>;

using noise::CosTurn;
using noise::Lerp;
using noise::SmoothStep;

// Derivative of CosTurn by its argument.
float CosTurnSlope(float x) { return -kTurn * CosTurn(x - 0.25f); }

}  // namespace

std::string_view WaterKindName(WaterKind kind) {
  return kind == WaterKind::kRiver ? "river" : "sea";
}

absl::StatusOr<WaterKind> ParseWaterKind(std::string_view name) {
  if (name == "river") return WaterKind::kRiver;
  if (name == "sea") return WaterKind::kSea;
  return InvalidArgument("there is no kind of water \"{}\": allowed are river, sea", name);
}

float SeenWidth(float across_m, float square_m) {
  return across_m * std::sqrt(std::max(1.0f, across_m / square_m));
}

Water::Water(const WaterSpec& spec) : spec_(spec) {
  const Vec2f direction(std::cos(spec.direction_rad), std::sin(spec.direction_rad));
  const bool river = spec.kind == WaterKind::kRiver;
  // Out to sea is to the right of a walk along its shore: v grows towards land.
  ahead_ = river ? direction : Vec2f(-direction.y(), direction.x());
  left_ = Vec2f(-ahead_.y(), ahead_.x());
  Rng rng(SceneSeed{spec.seed}, "water");
  struct Part {
    float length, height;
  };
  static constexpr Part kRiverParts[] = {{1, 0.62f}, {0.41f, 0.28f}, {2.7f, 0.22f}};
  static constexpr Part kSeaParts[] = {
      {2.6f, 0.7f}, {1, 0.6f}, {0.37f, 0.16f}, {0.137f, 0.045f}, {0.053f, 0.012f}};
  const auto add = [&](const Part& part) {
    bends_.push_back({1 / (part.length * spec.bend_m), static_cast<float>(rng.Uniform()),
                      part.height * spec.swing_m});
  };
  if (river) {
    for (const Part& part : kRiverParts) add(part);
  } else {
    for (const Part& part : kSeaParts) add(part);
  }
  for (float& phase : phases_) phase = static_cast<float>(rng.Uniform());
  river ? MakeRiverWaves() : MakeSeaWaves();
}

// The slopes of a sea's waves are as steep in one octave as in the next, up to the longest that the
// wind raises. Source: Pierson and Moskowitz, J. Geophys. Res. 69, 1964 (the longest); Cox and
// Munk, J. Opt. Soc. Am. 44, 1954 (mean square slope, 0.003 + 0.005 a m/s over some nine octaves).
void Water::MakeSeaWaves() {
  Rng rng(SceneSeed{spec_.seed}, "waves");
  constexpr float kRatio = 0.84f, kShortest_m = 0.12f;
  const float wind = std::max(spec_.wind_mps, 0.3f), an_octave = 0.0006f * wind;
  const float square_slope = an_octave * 0.25f;
  float length_m = std::clamp(0.55f * wind * wind, 1.2f, 26.0f), sum = 0;
  for (; length_m > kShortest_m; length_m *= kRatio) {
    // Short waves run every way, long ones with the wind.
    const double spread = 0.45 + 0.5 / (1 + static_cast<double>(length_m));
    const auto way = static_cast<float>(static_cast<double>(spec_.wind_rad) +
                                        std::clamp(rng.Normal(0, spread), -1.7, 1.7));
    const float own_m = length_m * static_cast<float>(rng.Uniform(0.93, 1.07));
    const float height_m = std::sqrt(2 * square_slope) * own_m / kTurn;
    waves_.push_back({Vec2f(std::cos(way), std::sin(way)) / own_m,
                      static_cast<float>(rng.Uniform()), height_m, own_m});
    sum += 0.5f * height_m * height_m;
  }
  lost_slope_ = 3 * an_octave + 0.0015f;
  most_wave_m_ = 3.2f * std::sqrt(sum) + 0.7f;
}

// Ripples of running water stand across the stream, and lie along it where it is quiet.
void Water::MakeRiverWaves() {
  Rng rng(SceneSeed{spec_.seed}, "waves");
  constexpr float kRatio = 0.8f, kShortest_m = 0.06f;
  const float square_slope = 0.00045f + 0.00005f * std::min(spec_.wind_mps, 10.0f);
  float sum = 0;
  for (float length_m = 2.2f; length_m > kShortest_m; length_m *= kRatio) {
    const auto way = static_cast<float>(std::clamp(rng.Normal(0, 0.75), -1.5, 1.5));
    const float own_m = length_m * static_cast<float>(rng.Uniform(0.92, 1.08));
    const float height_m = std::sqrt(2 * square_slope) * own_m / kTurn;
    // Along the stream, then across it.
    waves_.push_back({Vec2f(std::cos(way), std::sin(way)) / own_m,
                      static_cast<float>(rng.Uniform()), height_m, own_m});
    sum += 0.5f * height_m * height_m;
  }
  lost_slope_ = 0.0015f;
  most_wave_m_ = 3.5f * 2.6f * std::sqrt(sum) + 0.02f;
}

Water::OnLine Water::LineAt(float u) const {
  OnLine line;
  for (const Bend& bend : bends_) {
    const float turn = u * bend.turns_per_m + bend.phase, k = kTurn * bend.turns_per_m;
    const float cosine = CosTurn(turn);
    line.v += bend.height_m * cosine;
    line.slope += bend.height_m * bend.turns_per_m * CosTurnSlope(turn);
    line.bow -= bend.height_m * k * k * cosine;
  }
  return line;
}

// [-1, 1], along the axis.
float Water::Wandering(float u, float wavelength_m, int which) const {
  const float phase = phases_[static_cast<size_t>(which)];
  return 0.6f * CosTurn(u / wavelength_m + phase) +
         0.4f * CosTurn(u / (0.37f * wavelength_m) + 3.1f * phase);
}

Water::Local Water::LocalOf(const Vec2f& p) const {
  Local at;
  at.u = ahead_.dot(p);
  at.v = left_.dot(p);
  const OnLine line = LineAt(at.u);
  at.stretch = std::sqrt(1 + line.slope * line.slope);
  const float away = (at.v - line.v) / at.stretch;
  if (spec_.kind == WaterKind::kSea) {
    at.off = -away;
    at.from_shore_m = away;
    return at;
  }
  at.off = away;
  at.half_m = 0.5f * spec_.width_m * (1 + 0.22f * Wandering(at.u, 41, 0));
  const float sharpest = 0.75f * spec_.swing_m * std::pow(kTurn / spec_.bend_m, 2.0f);
  const float side = away >= 0 ? 1.0f : -1.0f;
  at.outer = std::clamp(-line.bow / std::max(sharpest, 1e-6f), -1.0f, 1.0f) * side;
  at.riffle = SmoothStep(0.2f, 0.75f, Wandering(at.u, 0.31f * spec_.bend_m, 1));
  at.from_shore_m = std::fabs(away) - at.half_m;
  return at;
}

float Water::Level(const Vec2f& p) const {
  const float along = spec_.kind == WaterKind::kRiver ? ahead_.dot(p) : 0;
  return spec_.level_m - spec_.fall * along - p.squaredNorm() / (2 * kEarthRadius_m);
}

float Water::FromShore(const Vec2f& p) const { return LocalOf(p).from_shore_m; }

Vec2f Water::Beside(float along_m, float from_shore_m, float side) const {
  const OnLine line = LineAt(along_m);
  const float stretch = std::sqrt(1 + line.slope * line.slope);
  float across = from_shore_m;
  if (spec_.kind == WaterKind::kRiver) {
    across = side * (0.5f * spec_.width_m * (1 + 0.22f * Wandering(along_m, 41, 0)) + from_shore_m);
  }
  return along_m * ahead_ + (line.v + across * stretch) * left_;
}

float Water::reach_m() const { return spec_.kind == WaterKind::kSea ? 1e9f : 4 * spec_.plain_m; }

// ---- The land

float Water::DepthAt(const Local& at) const {
  if (at.from_shore_m >= 0) return 0;
  if (spec_.kind == WaterKind::kSea) {
    const float x = spec_.slope * at.off / spec_.depth_m;
    return spec_.depth_m * x / (1 + x);
  }
  const float t = std::fabs(at.off) / at.half_m;
  return spec_.depth_m * (1 - 0.6f * at.riffle) * (1 - t * t) * (1 + 0.55f * at.outer * t);
}

// Height above the level, of banks and of the plain beside them. Outer banks of bends are cut,
// inner ones are bars of gravel.
float Water::RiverBed(const Local& at) const {
  if (at.from_shore_m < 0) return -DepthAt(at);
  const float steep = at.outer > 0 ? 1 + 2.2f * at.outer : 1 / (1 - 2.6f * at.outer);
  const float y = spec_.slope * steep * at.from_shore_m;
  return spec_.bank_m * y / (0.35f * spec_.bank_m + y) + 0.012f * at.from_shore_m;
}

// A beach, then the foot of dunes or of a bank.
float Water::SeaBed(const Local& at) const {
  if (at.from_shore_m < 0) return -DepthAt(at);
  const float x = at.from_shore_m, beach = spec_.slope * std::min(x, spec_.width_m);
  const float foot = spec_.width_m * (1 + 0.25f * Wandering(at.u, 47, 2));
  const float rise = std::max(0.1f, spec_.bank_m - spec_.slope * spec_.width_m);
  const float crest = rise * (1 + 0.35f * Wandering(at.u, 33, 3));
  return beach + crest * SmoothStep(0.9f * foot, 0.9f * foot + 0.4f * spec_.plain_m, x);
}

Water::Form Water::Shaped(const Vec2f& p, float height_m) const {
  const Local at = LocalOf(p);
  const bool river = spec_.kind == WaterKind::kRiver;
  const float first = river ? spec_.plain_m : spec_.width_m;
  const float last = river ? 4 * spec_.plain_m : spec_.width_m + 3 * spec_.plain_m;
  const float level = river ? spec_.level_m - spec_.fall * at.u : spec_.level_m;
  if (at.from_shore_m > last && river) return {height_m, 1};
  const float form = level + (river ? RiverBed(at) : SeaBed(at));
  const float natural = SmoothStep(first, last, at.from_shore_m);
  const float detail = DetailShare(at);
  if (natural <= 0) return {form, detail};
  // No land beside water lies lower than its bank.
  const float least = river ? form : std::min(form, level + 0.7f * spec_.bank_m);
  const float soft = std::max(height_m, least);
  return {Lerp(form, soft, natural), detail};
}

float Water::DetailShare(const Local& at) const {
  const float x = at.from_shore_m;
  if (spec_.kind == WaterKind::kRiver) return Lerp(0.45f, 1.0f, SmoothStep(0, spec_.plain_m, x));
  return Lerp(0.22f, 1.0f, SmoothStep(0.7f * spec_.width_m, spec_.width_m + 8, x));
}

// ---- The surface

float Water::Kept(float length_m, float depth_m) const {
  return depth_m / (depth_m + (spec_.kind == WaterKind::kSea ? 0.15f : 0.05f) * length_m);
}

float Water::Liveliness(const Local& at) const {
  if (spec_.kind == WaterKind::kSea) return 1;
  return 0.5f + 2.1f * at.riffle;
}

// Breakers run in parallel to the shore and the closer the shallower it is: their speed is the root
// of the depth. They are steep towards the shore, and break when they are as high as half of the
// depth.
Water::Surf Water::SurfAt(const Local& at) const {
  Surf surf;
  if (spec_.kind != WaterKind::kSea || at.off <= 0 || at.off > 90) return surf;
  const float depth = DepthAt(at);
  // The length of deep-water waves where the swell begins to feel the ground.
  const float wander = 0.45f * PlaneNoise({at.u / 43, 0.013f * at.off}, spec_.seed + 5) +
                       0.13f * PlaneNoise({at.u / 11, 0.03f * at.off}, spec_.seed + 6);
  const float turn = 1.05f * std::sqrt(at.off) + wander + phases_[4];
  const float within = noise::Fract(turn);
  // The face, towards the shore, is at small `within`: short and steep.
  const float warped =
      within < 0.28f ? 0.5f * within / 0.28f : 0.5f + 0.5f * (within - 0.28f) / 0.72f;
  const float form = 0.5f - 0.5f * CosTurn(warped);
  const float whole = std::floor(turn);
  const float part =
      SmoothStep(-0.35f, 0.3f, PlaneNoise({at.u / 23 + 7.3f * whole, 0.5f}, spec_.seed + 9));
  const float swell = std::min(0.1f + 0.075f * spec_.wind_mps, 0.75f);
  const float most = std::min(swell, 0.5f * depth) * (1 - SmoothStep(35, 85, at.off));
  surf.height_m = most * (0.35f + 0.65f * part) * (form * form * form - 0.3125f);
  surf.crest = form;
  surf.strength = part * SmoothStep(0.55f, 0.85f, swell / std::max(depth, 0.05f));
  return surf;
}

// How far above the level the last wave ran up the beach.
float Water::Swash(const Local& at) const {
  if (spec_.kind != WaterKind::kSea || at.off > 14) return 0;
  const float lobes = 0.5f + 0.5f * PlaneNoise({at.u / 9, 0.2f}, spec_.seed + 12) +
                      0.2f * PlaneNoise({at.u / 2.3f, 0.7f}, spec_.seed + 13);
  const float most = std::min(0.03f + 0.018f * spec_.wind_mps, 0.16f);
  return most * std::clamp(lobes, 0.0f, 1.2f) * (1 - SmoothStep(2, 14, at.off));
}

float Water::Waves(const Vec2f& p, float footprint_m) const {
  const Local at = LocalOf(p);
  const float depth = std::max(DepthAt(at), 0.0f), lively = Liveliness(at);
  const Vec2f q = spec_.kind == WaterKind::kSea ? p : Vec2f(at.u, at.off);
  float height = SurfAt(at).height_m + Swash(at);
  for (const Wave& wave : waves_) {
    const float shown = noise::Fade(0.5f * wave.length_m, footprint_m);
    if (shown <= 0) break;
    height += shown * lively * Kept(wave.length_m, depth) * wave.height_m *
              CosTurn(wave.turns_per_m.dot(q) + wave.phase);
  }
  return height;
}

Dual8 Water::Ripples(const Dual8& x, const Dual8& y, Float8 edge_m, Float8 footprint_m) const {
  Float8 depth, lively;
  Dual8 a = x, b = y;
  const bool sea = spec_.kind == WaterKind::kSea;
  if (!sea) {
    // In the river's frame; how it bends counts for the place, not for the slope.
    const Dual8 u = ahead_.x() * x + ahead_.y() * y, v = left_.x() * x + left_.y() * y;
    a = u;
    b = v;
  }
  for (int lane = 0; lane < kLanes; ++lane) {
    const Local at = LocalOf(Vec2f(x.value[lane], y.value[lane]));
    depth[lane] = std::max(DepthAt(at), 0.02f);
    lively[lane] = Liveliness(at);
    if (!sea) {
      a.value[lane] = at.u;
      b.value[lane] = at.off;
    }
  }
  Dual8 height = Splat(0);
  const float kept_by = sea ? 0.15f : 0.05f;
  for (const Wave& wave : waves_) {
    const Float8 shown = noise::Fade(wave.length_m, footprint_m) *
                         (1.0f - noise::Fade(0.5f * wave.length_m, edge_m));
    if (!Any(shown > 0)) continue;
    const Float8 kept = depth / (depth + kept_by * wave.length_m);
    const Dual8 turn = wave.turns_per_m.x() * a + wave.turns_per_m.y() * b + wave.phase;
    height += (shown * kept * lively * wave.height_m) * CosTurn(turn);
  }
  return height;
}

float Water::LostSlope(const Vec2f& p, float footprint_m) const {
  const Local at = LocalOf(p);
  const float lively = Liveliness(at);
  float slope = lost_slope_;
  for (const Wave& wave : waves_) {
    const float shown = noise::Fade(wave.length_m, footprint_m);
    const float k = kTurn * wave.height_m / wave.length_m * lively;
    slope += 0.5f * k * k * (1 - shown * shown);
  }
  return slope;
}

float Water::Foam(const Vec2f& p, float depth_m) const {
  const Local at = LocalOf(p);
  if (spec_.kind == WaterKind::kRiver) {
    const float quick = at.riffle * SmoothStep(0.3f, 0.0f, std::fabs(at.from_shore_m) * 0.02f);
    return 0.2f * quick * (0.6f + 0.4f * PlaneNoise({at.u / 7, at.off / 1.6f}, spec_.seed + 21));
  }
  if (at.off > 120) {
    // Whitecaps. Source: Monahan and O'Muircheartaigh, J. Phys. Oceanogr. 10, 1980, about.
    const float wind = spec_.wind_mps;
    return std::min(0.25f, 4e-6f * wind * wind * wind * std::sqrt(wind) * 6);
  }
  const Surf surf = SurfAt(at);
  const float broken = surf.strength * SmoothStep(0.45f, 0.85f, surf.crest);
  // Waves that lay threads of foam on the shallows come with the wind.
  const float lace = 0.42f * std::min(1.0f, spec_.wind_mps / 5) *
                     (1 - SmoothStep(0.25f, 1.5f, depth_m)) *
                     SmoothStep(-0.5f, 0.4f, PlaneNoise({at.u / 17, at.off / 6}, spec_.seed + 31));
  const float edge = 0.9f * (1 - SmoothStep(0.008f, 0.05f, depth_m));
  return std::clamp(std::max({broken, lace, edge}), 0.0f, 1.0f);
}

Vec2f Water::Adrift(const Vec2f& p) const {
  if (spec_.kind == WaterKind::kSea) return p;
  const Local at = LocalOf(p);
  return {at.u, at.off};
}

}  // namespace parallax
