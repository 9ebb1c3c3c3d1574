// The forms that a landscape starts from, before water works on it: a sum of terms, each one kind
// of relief with its wavelength and height. Pure functions of position and seed; thread-safe.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "worker/terrain/field.h"

namespace parallax {

enum class TermKind {
  kHills,    // Soft swells of gradient noise.
  kRidges,   // Sharp crests over wide valleys: a mountain range.
  kBillows,  // Round tops between narrow valleys: old hills, pillow rock.
  kPlateau,  // Hills cut into benches with steep steps between them: mesas, canyons.
  kDunes,    // Asymmetric ridges across the wind: gentle windward side, steep lee.
  kRamp,     // An even slope that rises along `direction_rad`.
};

struct TerrainTerm {
  TermKind kind = TermKind::kHills;
  float wavelength_m = 500;  // Of the largest forms.
  float amplitude_m =
      50;  // Standard height: most of the relief lies within +- this. Ramp: rise over a wavelength.
  int octaves = 5;     // Each 0.48 as long as the one before.
  float gain = 0.5f;   // Height of an octave over that of the one before.
  float warp = 0.25f;  // The position is moved by noise of this many wavelengths: no form repeats.
  float sharpness = 0.5f;   // Plateau: share of the height that stands in steps. Dunes: lee over
                            // windward length is 1 - this.
  float direction_rad = 0;  // Ramp: uphill. Dunes: wind blows towards.
  uint32_t seed = 0;
};

// The names that recipes and configs use: "hills", "ridges"...
std::string_view TermKindName(TermKind kind);
// Errors: kInvalidArgument naming the kinds that there are.
absl::StatusOr<TermKind> ParseTermKind(std::string_view name);

// Height at a world position, metres; detail shorter than `footprint_m` is left out.
float TermHeight(const TerrainTerm& term, const Vec2f& p, float footprint_m);

// The sum of all terms at each sample of `field`, whose spacing is the footprint.
void FillWithTerms(const std::vector<TerrainTerm>& terms, Field& field);

}  // namespace parallax
