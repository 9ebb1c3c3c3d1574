#include "worker/terrain/terms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "worker/materials/kernel/noise.h"
#include "worker/terrain/plane_noise.h"

namespace parallax {
namespace {

constexpr std::array<std::pair<TermKind, std::string_view>, 8> kNames = {{
    {TermKind::kHills, "hills"},
    {TermKind::kRidges, "ridges"},
    {TermKind::kBillows, "billows"},
    {TermKind::kPlateau, "plateau"},
    {TermKind::kDunes, "dunes"},
    {TermKind::kRamp, "ramp"},
    {TermKind::kGorge, "gorge"},
    {TermKind::kScarp, "scarp"},
}};

// Slope of the debris at the foot of a wall: 33 degrees.
constexpr float kTalus = 0.65f;
// Slope of dry sand: 32 degrees.
constexpr float kRepose = 0.62f;

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

// How many dunes lie between the origin and `p`: crests bend, as it wanders slowly along them.
float DunePhase(const TerrainTerm& term, const Vec2f& p) {
  const Vec2f wind(std::cos(term.direction_rad), std::sin(term.direction_rad));
  const Vec2f slow = p / (3.0f * term.wavelength_m);
  const Vec2f along(1.5f * wind.dot(slow), wind.x() * slow.y() - wind.y() * slow.x());
  return wind.dot(p) / term.wavelength_m + 4.0f * term.warp * PlaneNoise(along, term.seed + 3) +
         0.5f * term.warp * PlaneNoise(4.0f * along, term.seed + 5);
}

float Dunes(const TerrainTerm& term, const Vec2f& p, float footprint_m) {
  const Vec2f wind(std::cos(term.direction_rad), std::sin(term.direction_rad));
  const float phase = DunePhase(term, p), step_m = 0.02f * term.wavelength_m;
  // Where crests crowd, dunes are shorter; all in amplitudes.
  const float dunes_a_m = std::fabs(DunePhase(term, p + step_m * wind) - phase) / step_m;
  const float length = 1 / std::max(dunes_a_m, 0.3f / term.wavelength_m) / term.amplitude_m;
  const Vec2f slow = p / (1.5f * term.wavelength_m);
  const float strength = noise::SmoothStep(
      -0.45f, 0.4f,
      PlaneNoise({1.5f * wind.dot(slow), wind.x() * slow.y() - wind.y() * slow.x()},
                 term.seed + 7));
  // Sand slides down the lee at its angle of repose, however high the dune is; the highest just fit
  // in between.
  const float in_dune = noise::Fract(phase);
  const float crest = std::clamp(1 - 2.0f / (kRepose * length), 0.5f, 0.9f);
  const float top = std::min(2 * strength, kRepose * (1 - crest) * length);
  const float height = in_dune < crest ? top * noise::SmoothStep(0, crest, in_dune)
                                       : std::max(0.0f, top - kRepose * (in_dune - crest) * length);
  return (height - 0.6f) * Kept(term.wavelength_m, footprint_m);
}

float Ramp(const TerrainTerm& term, const Vec2f& p) {
  return (std::cos(term.direction_rad) * p.x() + std::sin(term.direction_rad) * p.y()) /
         term.wavelength_m;
}

Vec2f Heading(float direction_rad) { return {std::cos(direction_rad), std::sin(direction_rad)}; }

// Spurs and bays of three sizes, in units of the wavelength.
float Crags(const TerrainTerm& term, const Vec2f& p) {
  const Vec2f q = p / term.wavelength_m;
  return 0.55f * PlaneNoise(2.6f * q, term.seed + 61) +
         0.22f * PlaneNoise(6.7f * q, term.seed + 67) +
         0.09f * PlaneNoise(17.0f * q, term.seed + 71);
}

// A place on a wall.
struct WallHeight {
  float height = 0;  // Above the foot, over the wall's, in [0, 1].
  float debris = 0;
};
// A wall `height_m` high at a distance `out_m` behind its foot: an apron of debris up to this share
// of the height, then a face of the slope `face`, rounded off above.
WallHeight Wall(float out_m, float height_m, float face, float apron) {
  if (out_m <= 0) {
    // The apron runs out in front of the foot.
    const float reach = 0.6f * apron * height_m / kTalus;
    const float t = std::max(0.0f, 1 + out_m / std::max(reach, 0.1f));
    return {0.3f * apron * t * t, noise::SmoothStep(0.15f, 0.6f, t)};
  }
  const float talus = 0.3f * apron + kTalus * out_m / height_m;
  const float rock = face * (out_m / height_m - 0.25f * apron);
  const float debris = std::min(talus, apron);
  const float low = std::max(debris, rock);
  return {low < 0.9f ? low : 1 - 0.1f * std::exp(-(low - 0.9f) / 0.1f),
          rock < debris ? 1.0f : 0.0f};
}

// The middle line leaves the gorge's axis by this much.
float Winding(const TerrainTerm& term, float along_m) {
  const float t = along_m / term.wavelength_m;
  return term.warp * term.wavelength_m *
         (PlaneNoise({t, 0.37f}, term.seed + 3) +
          0.3f * PlaneNoise({2.7f * t, 1.9f}, term.seed + 5));
}

WallHeight GorgeWall(const TerrainTerm& term, const Vec2f& p) {
  const GorgePlace at = PlaceInGorge(term, p);
  // Walls go in and out, the floor stays open.
  const float open = noise::SmoothStep(0.4f * at.half_m, 1.2f * at.half_m + 2, at.away_m);
  const float out =
      at.away_m - at.half_m + open * 0.5f * term.warp * term.wavelength_m * Crags(term, p);
  const float face = noise::Lerp(0.9f, 7.0f, term.sharpness * term.sharpness);
  const float fans = 0.5f + 0.9f * PlaneNoise(p / (0.7f * term.wavelength_m), term.seed + 83);
  const float apron = noise::Lerp(0.35f, 0.12f, term.sharpness) * std::clamp(fans, 0.0f, 1.3f);
  return Wall(out, std::fabs(term.amplitude_m), face, apron);
}

// How far behind the foot of the wall.
float OutOfScarp(const TerrainTerm& term, const Vec2f& p) {
  const Vec2f uphill = Heading(term.direction_rad), along(-uphill.y(), uphill.x());
  return uphill.dot(p) + Winding(term, along.dot(p)) +
         0.5f * term.warp * term.wavelength_m * Crags(term, p);
}

WallHeight ScarpWall(const TerrainTerm& term, const Vec2f& p) {
  const float out = OutOfScarp(term, p);
  const float height = std::fabs(term.amplitude_m);
  const float fans = 0.45f + 1.1f * PlaneNoise(p / (0.5f * term.wavelength_m), term.seed + 83);
  const float apron = noise::Lerp(0.6f, 0.12f, term.sharpness) * std::clamp(fans, 0.1f, 1.3f);
  return Wall(out, height, height / std::max(term.width_m, 0.5f), apron);
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
    default:
      break;  // Walls, which TermHeight knows.
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
  return InvalidArgument("there is no terrain term \"{}\": allowed are {}", name, known);
}

float TermHeight(const TerrainTerm& term, const Vec2f& p, float footprint_m, float* debris) {
  if (debris) *debris = 0;
  if (term.kind != TermKind::kGorge && term.kind != TermKind::kScarp) {
    return term.amplitude_m * UnitHeight(term, p, footprint_m);
  }
  const bool gorge = term.kind == TermKind::kGorge;
  const WallHeight wall = gorge ? GorgeWall(term, p) : ScarpWall(term, p);
  if (debris) *debris = wall.debris;
  return term.amplitude_m * (gorge ? wall.height - 1 : wall.height);
}

GorgePlace PlaceInGorge(const TerrainTerm& gorge, const Vec2f& p) {
  const Vec2f ahead = Heading(gorge.direction_rad);
  GorgePlace at;
  at.along_m = ahead.dot(p);
  const float across = ahead.x() * p.y() - ahead.y() * p.x();
  constexpr float kStep_m = 2;
  const float middle = Winding(gorge, at.along_m);
  // The line leans: across is longer than away.
  const float lean = (Winding(gorge, at.along_m + kStep_m) - middle) / kStep_m;
  at.away_m = std::fabs(across - middle) / std::sqrt(1 + lean * lean);
  const float wide = PlaneNoise({2.2f * at.along_m / gorge.wavelength_m, 4.1f}, gorge.seed + 13);
  at.half_m = 0.5f * gorge.width_m * (1 + 0.8f * std::clamp(wide, -0.6f, 0.8f));
  return at;
}

Vec2f GorgeMiddle(const TerrainTerm& gorge, float along_m) {
  const Vec2f ahead = Heading(gorge.direction_rad), left(-ahead.y(), ahead.x());
  return along_m * ahead + Winding(gorge, along_m) * left;
}

Vec2f ScarpFoot(const TerrainTerm& scarp, float along_m, float out_m) {
  const Vec2f uphill = Heading(scarp.direction_rad);
  Vec2f p = along_m * Vec2f(-uphill.y(), uphill.x());
  // Crags change little over the way that is left.
  for (int i = 0; i < 5; ++i) p += (out_m - OutOfScarp(scarp, p)) * 0.8f * uphill;
  return p;
}

void FillWithTerms(const std::vector<TerrainTerm>& terms, Field& field) {
  ForRows(field, [&](int row) {
    for (int column = 0; column < field.size; ++column) {
      float height = 0;
      for (const TerrainTerm& term : terms) {
        height += TermHeight(term, field.PositionOf(column, row), field.cell_m);
      }
      field.At(column, row) = height;
    }
  });
}

}  // namespace parallax
