#include "worker/terrain/terms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "worker/materials/noise.h"

namespace parallax {
namespace {

constexpr std::array<std::pair<TermKind, std::string_view>, 6> kNames = {{
    {TermKind::kHills, "hills"},
    {TermKind::kRidges, "ridges"},
    {TermKind::kBillows, "billows"},
    {TermKind::kPlateau, "plateau"},
    {TermKind::kDunes, "dunes"},
    {TermKind::kRamp, "ramp"},
}};

// Slices of one solid noise: gradient noise of the plane has visible axes, a tilted slice has not.
float PlaneNoise(const Vec2f& p, uint32_t seed) {
  return noise::Gradient3(p.x(), p.y(), 0.31f * p.x() - 0.23f * p.y(), seed);
}

// How much of an octave a raster of this spacing can carry.
float Kept(float wavelength_m, float footprint_m) { return noise::Fade(wavelength_m, footprint_m); }

Vec2f Warped(const TerrainTerm& term, const Vec2f& p) {
  const Vec2f q = p / term.wavelength_m;
  const Vec2f shift(PlaneNoise(q, term.seed + 11), PlaneNoise(q, term.seed + 23));
  const Vec2f finer(PlaneNoise(3.1f * q, term.seed + 37), PlaneNoise(3.1f * q, term.seed + 53));
  return q + 2.0f * term.warp * (shift + 0.25f * finer);
}

// Sum of octaves of one shape of noise; `shape` takes noise in about [-1, 1] and gives the same.
// With `follow`, an octave is as strong as the one before is high: detail sits on crests, valleys
// stay smooth.   Source: Musgrave, "Hybrid multifractal", in "Texturing and Modeling", 1994.
template <typename Shape>
float Octaves(const TerrainTerm& term, const Vec2f& p, float footprint_m, bool follow,
              Shape shape) {
  Vec2f q = Warped(term, p);
  float wavelength_m = term.wavelength_m, strength = 1, sum = 0, weight = 1;
  for (int i = 0; i < term.octaves; ++i) {
    const float kept = Kept(wavelength_m, footprint_m);
    if (kept <= 0) break;
    const float value = shape(PlaneNoise(q, term.seed + static_cast<uint32_t>(i) * 977u));
    sum += kept * strength * weight * value;
    if (follow) weight = std::clamp(weight * (0.55f + 0.9f * value), 0.0f, 1.0f);
    // Turned by a third of a right angle, so that octaves' lattices do not line up.
    q = Vec2f(0.866f * q.x() - 0.5f * q.y(), 0.5f * q.x() + 0.866f * q.y()) / 0.48f;
    wavelength_m *= 0.48f;
    strength *= term.gain;
  }
  return sum;
}

float Hills(const TerrainTerm& term, const Vec2f& p, float footprint_m) {
  return 1.6f * Octaves(term, p, footprint_m, false, [](float n) { return n; });
}

float Ridges(const TerrainTerm& term, const Vec2f& p, float footprint_m) {
  return Octaves(term, p, footprint_m, true, [](float n) {
    const float crest = 1 - std::min(1.0f, 1.9f * std::fabs(n));
    return 1.6f * crest * crest - 0.55f;
  });
}

float Billows(const TerrainTerm& term, const Vec2f& p, float footprint_m) {
  return Octaves(term, p, footprint_m, true,
                 [](float n) { return 3.2f * std::min(0.6f, std::fabs(n)) - 0.7f; });
}

float Plateau(const TerrainTerm& term, const Vec2f& p, float footprint_m) {
  const float smooth = Hills(term, p, footprint_m);
  constexpr float kBenches = 2.2f;  // In the height of an amplitude.
  const float level = smooth * kBenches, bench = std::floor(level);
  const float rise = noise::SmoothStep(0.5f - 0.14f, 0.5f + 0.14f, level - bench);
  return noise::Lerp(smooth, (bench + rise) / kBenches, std::clamp(term.sharpness, 0.0f, 1.0f));
}

float Dunes(const TerrainTerm& term, const Vec2f& p, float footprint_m) {
  const Vec2f wind(std::cos(term.direction_rad), std::sin(term.direction_rad));
  const Vec2f across(-wind.y(), wind.x());
  // Crests bend and end: the phase and the height wander slowly along them.
  const Vec2f slow = p / (3.0f * term.wavelength_m);
  const Vec2f along(wind.dot(slow) * 1.5f, across.dot(slow));
  const float phase = wind.dot(p) / term.wavelength_m +
                      4.0f * term.warp * PlaneNoise(along, term.seed + 3) +
                      0.5f * term.warp * PlaneNoise(4.0f * along, term.seed + 5);
  const float in_dune = noise::Fract(phase);
  const float crest = 1 - 0.5f * std::clamp(1 - term.sharpness, 0.1f, 1.0f);
  const float windward = noise::SmoothStep(0, crest, in_dune);
  const float lee = 1 - (in_dune - crest) / (1 - crest);
  const float height = in_dune < crest ? windward : lee;
  const float strength = noise::SmoothStep(-0.45f, 0.35f, PlaneNoise(2.0f * along, term.seed + 7));
  return (2 * height - 1) * strength * Kept(term.wavelength_m, footprint_m);
}

float Ramp(const TerrainTerm& term, const Vec2f& p) {
  return (std::cos(term.direction_rad) * p.x() + std::sin(term.direction_rad) * p.y()) /
         term.wavelength_m;
}

float UnitHeight(const TerrainTerm& term, const Vec2f& p, float footprint_m) {
  switch (term.kind) {
    case TermKind::kHills:
      return Hills(term, p, footprint_m);
    case TermKind::kRidges:
      return Ridges(term, p, footprint_m);
    case TermKind::kBillows:
      return Billows(term, p, footprint_m);
    case TermKind::kPlateau:
      return Plateau(term, p, footprint_m);
    case TermKind::kDunes:
      return Dunes(term, p, footprint_m);
    case TermKind::kRamp:
      return Ramp(term, p);
  }
  return 0;
}

}  // namespace

std::string_view TermKindName(TermKind kind) {
  for (const auto& [known, name] : kNames) {
    if (known == kind) return name;
  }
  return "unknown";
}

absl::StatusOr<TermKind> ParseTermKind(std::string_view name) {
  std::string known;
  for (const auto& [kind, kind_name] : kNames) {
    if (kind_name == name) return kind;
    known += (known.empty() ? "" : ", ") + std::string(kind_name);
  }
  return MakeError(absl::StatusCode::kInvalidArgument,
                   "there is no terrain term \"" + std::string(name) + "\": allowed are " + known);
}

float TermHeight(const TerrainTerm& term, const Vec2f& p, float footprint_m) {
  return term.amplitude_m * UnitHeight(term, p, footprint_m);
}

void FillWithTerms(const std::vector<TerrainTerm>& terms, Field& field) {
  for (int row = 0; row < field.size; ++row) {
    for (int column = 0; column < field.size; ++column) {
      float height = 0;
      for (const TerrainTerm& term : terms) {
        height += TermHeight(term, field.PositionOf(column, row), field.cell_m);
      }
      field.At(column, row) = height;
    }
  }
}

}  // namespace parallax
