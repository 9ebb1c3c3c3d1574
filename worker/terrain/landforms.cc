#include "worker/terrain/landforms.h"

#include <numbers>
#include <utility>

namespace parallax {
namespace {

float Draw(Rng& rng, double low, double high) { return static_cast<float>(rng.Uniform(low, high)); }

// Wide swells with shallow valleys, some metres of relief about the walk.
void Plain(Rng& rng, TerrainSpec& spec) {
  spec.terms.push_back({.kind = TermKind::kHills,
                        .wavelength_m = Draw(rng, 2200, 4200),
                        .amplitude_m = Draw(rng, 5, 12),
                        .octaves = 4,
                        .seed = rng.Bits32()});
  spec.terms.push_back({.kind = TermKind::kHills,
                        .wavelength_m = Draw(rng, 160, 320),
                        .amplitude_m = Draw(rng, 0.8, 2.2),
                        .octaves = 3,
                        .seed = rng.Bits32()});
  // Hills at the edge of sight.
  spec.terms.push_back({.kind = TermKind::kBillows,
                        .wavelength_m = Draw(rng, 7000, 12000),
                        .amplitude_m = Draw(rng, 8, 40),
                        .octaves = 5,
                        .seed = rng.Bits32()});
  spec.streams = {.steps = 40, .erodibility = 0.3f, .talus = 0.4f, .diffusion = 0.5f};
  spec.rain.droplets = 60'000;
  spec.gravity.passes = 4;
  spec.roughness = 0.55f;
}

// Wooded hills: slopes of 5 to 25 degrees, small valleys with a floor.
void Hills(Rng& rng, TerrainSpec& spec) {
  spec.terms.push_back({.kind = TermKind::kHills,
                        .wavelength_m = Draw(rng, 1100, 2000),
                        .amplitude_m = Draw(rng, 16, 40),
                        .octaves = 6,
                        .seed = rng.Bits32()});
  spec.terms.push_back({.kind = TermKind::kHills,
                        .wavelength_m = Draw(rng, 60, 110),
                        .amplitude_m = Draw(rng, 1.2, 2.6),
                        .octaves = 3,
                        .seed = rng.Bits32()});
  spec.terms.push_back({.kind = TermKind::kRidges,
                        .wavelength_m = Draw(rng, 8000, 12000),
                        .amplitude_m = Draw(rng, 25, 90),
                        .octaves = 6,
                        .seed = rng.Bits32()});
  spec.streams = {.steps = 45, .erodibility = 0.35f, .talus = 0.6f, .diffusion = 0.35f};
  spec.rain.droplets = 120'000;
  spec.gravity.passes = 10;
  spec.roughness = 1.0f;
}

// A range: crests, branching valleys, cliffs over screes.
void Mountains(Rng& rng, TerrainSpec& spec) {
  spec.terms.push_back({.kind = TermKind::kRidges,
                        .wavelength_m = Draw(rng, 3200, 5200),
                        .amplitude_m = Draw(rng, 260, 480),
                        .octaves = 3,
                        .warp = 0.3f,
                        .seed = rng.Bits32()});
  spec.terms.push_back({.kind = TermKind::kHills,
                        .wavelength_m = Draw(rng, 280, 480),
                        .amplitude_m = Draw(rng, 14, 30),
                        .octaves = 5,
                        .seed = rng.Bits32()});
  spec.streams = {.steps = 55, .erodibility = 0.4f, .talus = 1.1f, .diffusion = 0.08f};
  spec.rain.droplets = 220'000;
  spec.gravity.passes = 30;
  spec.gravity.band_m = Draw(rng, 25, 60);
  spec.roughness = 2.2f;
}

struct Landform {
  std::string_view name;
  void (*draw)(Rng& rng, TerrainSpec& spec);
};
constexpr Landform kLandforms[] = {{"hills", Hills}, {"mountains", Mountains}, {"plain", Plain}};

}  // namespace

std::vector<std::string> LandformNames() {
  std::vector<std::string> names;
  for (const Landform& landform : kLandforms) names.emplace_back(landform.name);
  return names;
}

absl::StatusOr<TerrainSpec> DrawLandform(std::string_view name, const Rng& rng) {
  std::string known;
  for (const Landform& landform : kLandforms) {
    if (landform.name != name) {
      known += (known.empty() ? "" : ", ") + std::string(landform.name);
      continue;
    }
    TerrainSpec spec;
    Rng draws = rng.Child("landform");
    landform.draw(draws, spec);
    spec.seed = draws.Bits64();
    return spec;
  }
  return MakeError(absl::StatusCode::kInvalidArgument,
                   "there is no landform \"" + std::string(name) + "\": allowed are " + known);
}

}  // namespace parallax
