// The forms of a landscape before erosion: a sum of terms, each one kind of relief with its
// wavelength and height. Pure functions of position and seed; thread-safe.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "worker/terrain/field.h"

namespace parallax {

// Kinds of relief.
enum class TermKind {
  kHills,    // Soft swells of gradient noise.
  kRidges,   // Sharp crests over wide valleys: a mountain range.
  kBillows,  // Round tops between narrow valleys: old hills, pillow rock.
  kPlateau,  // Hills cut into benches with steep steps between them: mesas, canyons.
  kDunes,    // Asymmetric ridges across the wind: gentle windward side, steep lee.
  kRamp,     // An even slope that rises along `direction_rad`.
  kGorge,    // A valley with a floor between walls, about a line along `direction_rad` through the
             // origin that winds; 0 outside, minus the amplitude on its floor.
  kScarp,    // A cliff across `direction_rad`: level below, level above, crags and bays between.
};

// One term of the sum.
struct TerrainTerm {
  TermKind kind = TermKind::kHills;
  float wavelength_m = 500;  // Length of the largest forms.
  // Standard height: most of the relief lies within +- this. Ramp: rise over a wavelength.
  float amplitude_m = 50;
  int octaves = 5;     // Each 0.48 as long as the one before.
  float gain = 0.5f;   // Height of an octave over that of the one before.
  float warp = 0.25f;  // Position noise, in wavelengths, so that no form repeats.
  // Plateau: share of the height in steps. Gorge: steepness of the walls. Scarp: lack of debris at
  // its foot.
  float sharpness = 0.5f;
  float direction_rad = 0;  // Ramp, scarp: uphill. Dunes: wind blows towards. Gorge: along it.
  float width_m = 0;        // Gorge: width of its floor. Scarp: width of its face.
  uint32_t seed = 0;
};

// Returns the names that recipes and configs use: "hills", "ridges"...
std::string_view TermKindName(TermKind kind);
// Returns the kind of that name. Errors: kInvalidArgument for an unknown name, listing the kinds.
absl::StatusOr<TermKind> ParseTermKind(std::string_view name);

// Returns the height at a world position, metres, without detail shorter than `footprint_m`.
// `debris`, if given, is set to the term's amount of loose rock there, in [0, 1]: aprons at the
// feet of walls.
float TermHeight(const TerrainTerm& term, const Vec2f& p, float footprint_m,
                 float* debris = nullptr);

// A position relative to a gorge.
struct GorgePlace {
  float along_m = 0;  // From the origin.
  float away_m = 0;   // From its middle line, >= 0.
  float half_m = 0;   // Half of the floor's width there.
};
GorgePlace PlaceInGorge(const TerrainTerm& gorge, const Vec2f& p);
// Returns a point of the gorge's middle line.
Vec2f GorgeMiddle(const TerrainTerm& gorge, float along_m);
// Returns the point `out_m` uphill of the foot of a scarp's wall, below it where negative.
Vec2f ScarpFoot(const TerrainTerm& scarp, float along_m, float out_m);

// Sets each sample of `field` to the sum of all terms there; the field's spacing is the footprint.
void FillWithTerms(const std::vector<TerrainTerm>& terms, Field& field);

}  // namespace parallax
