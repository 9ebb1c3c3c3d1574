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

// A valley whose floor falls gently along a river that bends through it.
void River(Rng& rng, TerrainSpec& spec) {
  const float direction = Draw(rng, -3.14, 3.14), fall = Draw(rng, 0.002, 0.012);
  const float relief = Draw(rng, 10, 34);
  spec.terms.push_back({.kind = TermKind::kRamp,
                        .wavelength_m = 1000,
                        .amplitude_m = 1000 * fall,
                        .direction_rad = direction + std::numbers::pi_v<float>});
  spec.terms.push_back({.kind = TermKind::kHills,
                        .wavelength_m = Draw(rng, 550, 1100),
                        .amplitude_m = relief,
                        .octaves = 5,
                        .seed = rng.Bits32()});
  spec.terms.push_back({.kind = TermKind::kHills,
                        .wavelength_m = Draw(rng, 45, 90),
                        .amplitude_m = Draw(rng, 0.5, 1.2),
                        .octaves = 3,
                        .seed = rng.Bits32()});
  spec.terms.push_back({.kind = TermKind::kRidges,
                        .wavelength_m = Draw(rng, 6000, 10000),
                        .amplitude_m = Draw(rng, 30, 110),
                        .octaves = 6,
                        .seed = rng.Bits32()});
  WaterSpec& water = spec.water.emplace();
  water.kind = WaterKind::kRiver;
  water.direction_rad = direction;
  water.fall = fall;
  water.level_m = -Draw(rng, 0.6, 1.1) * relief;
  water.bend_m = Draw(rng, 120, 250);
  water.swing_m = water.bend_m * Draw(rng, 0.07, 0.13);
  water.width_m = Draw(rng, 8, 24);
  water.depth_m = Draw(rng, 0.5, 1.5);
  water.slope = Draw(rng, 0.2, 0.42);
  water.bank_m = Draw(rng, 0.7, 1.5);
  water.plain_m = Draw(rng, 12, 45);
  water.seed = rng.Bits32();
  spec.streams = {.steps = 35, .erodibility = 0.35f, .talus = 0.7f, .diffusion = 0.3f};
  spec.rain.droplets = 100'000;
  spec.gravity.passes = 10;
  spec.roughness = 0.8f;
}

// Hills that end at the sea: behind a beach with dunes, or behind shingle and a rocky bank.
void Coast(Rng& rng, TerrainSpec& spec) {
  const float direction = Draw(rng, -3.14, 3.14);
  const bool sandy = rng.Bernoulli(0.65);
  spec.terms.push_back({.kind = TermKind::kRamp,
                        .wavelength_m = 1000,
                        .amplitude_m = Draw(rng, 4, 20),
                        .direction_rad = direction + std::numbers::pi_v<float>});
  spec.terms.push_back({.kind = TermKind::kHills,
                        .wavelength_m = Draw(rng, 420, 1000),
                        .amplitude_m = sandy ? Draw(rng, 6, 24) : Draw(rng, 16, 46),
                        .octaves = 5,
                        .seed = rng.Bits32()});
  spec.terms.push_back({.kind = TermKind::kHills,
                        .wavelength_m = Draw(rng, 20, 36),
                        .amplitude_m = sandy ? Draw(rng, 0.9, 1.9) : Draw(rng, 0.5, 1.2),
                        .octaves = 3,
                        .seed = rng.Bits32()});
  spec.terms.push_back({.kind = TermKind::kRidges,
                        .wavelength_m = Draw(rng, 5000, 8000),
                        .amplitude_m = Draw(rng, 20, 80),
                        .octaves = 6,
                        .seed = rng.Bits32()});
  WaterSpec& water = spec.water.emplace();
  water.kind = WaterKind::kSea;
  water.direction_rad = direction;
  water.bend_m = Draw(rng, 300, 700);
  water.swing_m = water.bend_m * Draw(rng, 0.04, 0.08);
  water.width_m = sandy ? Draw(rng, 22, 48) : Draw(rng, 5, 11);
  water.depth_m = Draw(rng, 8, 14);
  water.slope = sandy ? Draw(rng, 0.055, 0.1) : Draw(rng, 0.18, 0.4);
  water.bank_m = water.slope * water.width_m + (sandy ? Draw(rng, 0.8, 2.6) : Draw(rng, 2, 7));
  water.plain_m = sandy ? Draw(rng, 30, 70) : Draw(rng, 18, 40);
  water.seed = rng.Bits32();
  spec.streams = {.steps = 35, .erodibility = 0.35f, .talus = 0.8f, .diffusion = 0.25f};
  spec.rain.droplets = 90'000;
  spec.gravity.passes = 12;
  spec.roughness = sandy ? 0.7f : 1.6f;
}

// Low land under ice and drifted snow, which ends in a calm sea.
void Arctic(Rng& rng, TerrainSpec& spec) {
  const float direction = Draw(rng, -3.14, 3.14);
  spec.terms.push_back({.kind = TermKind::kHills,
                        .wavelength_m = Draw(rng, 350, 800),
                        .amplitude_m = Draw(rng, 3, 11),
                        .octaves = 5,
                        .seed = rng.Bits32()});
  spec.terms.push_back({.kind = TermKind::kDunes,
                        .wavelength_m = Draw(rng, 11, 20),
                        .amplitude_m = Draw(rng, 0.12, 0.3),
                        .octaves = 1,
                        .sharpness = 0.75f,
                        .direction_rad = Draw(rng, -3.14, 3.14),
                        .seed = rng.Bits32()});
  spec.terms.push_back({.kind = TermKind::kHills,
                        .wavelength_m = Draw(rng, 40, 90),
                        .amplitude_m = Draw(rng, 0.5, 1.3),
                        .octaves = 3,
                        .seed = rng.Bits32()});
  spec.terms.push_back({.kind = TermKind::kRidges,
                        .wavelength_m = Draw(rng, 4500, 8000),
                        .amplitude_m = Draw(rng, 25, 110),
                        .octaves = 6,
                        .seed = rng.Bits32()});
  WaterSpec& water = spec.water.emplace();
  water.kind = WaterKind::kSea;
  water.direction_rad = direction;
  water.bend_m = Draw(rng, 220, 520);
  water.swing_m = water.bend_m * Draw(rng, 0.05, 0.09);
  water.width_m = Draw(rng, 4, 12);
  water.depth_m = Draw(rng, 8, 14);
  water.slope = Draw(rng, 0.1, 0.25);
  water.bank_m = water.slope * water.width_m + Draw(rng, 0.6, 2.2);
  water.plain_m = Draw(rng, 30, 80);
  water.seed = rng.Bits32();
  spec.streams = {.steps = 25, .erodibility = 0.3f, .talus = 0.9f, .diffusion = 0.3f};
  spec.rain.droplets = 30'000;
  spec.gravity.passes = 8;
  spec.roughness = 0.5f;
}

struct Landform {
  std::string_view name;
  void (*draw)(Rng& rng, TerrainSpec& spec);
};
constexpr Landform kLandforms[] = {{"arctic", Arctic},       {"coast", Coast}, {"hills", Hills},
                                   {"mountains", Mountains}, {"plain", Plain}, {"river", River}};

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
