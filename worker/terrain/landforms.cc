#include "worker/terrain/landforms.h"

#include <numbers>
#include <utility>

namespace parallax {
namespace {

float Draw(Rng& rng, double low, double high) { return static_cast<float>(rng.Uniform(low, high)); }

struct Range {
  double low, high;
};

// A term with a wavelength, an amplitude and a seed, drawn in this order.
TerrainTerm Term(Rng& rng, TermKind kind, Range wavelength_m, Range amplitude_m, int octaves) {
  return {.kind = kind,
          .wavelength_m = Draw(rng, wavelength_m.low, wavelength_m.high),
          .amplitude_m = Draw(rng, amplitude_m.low, amplitude_m.high),
          .octaves = octaves,
          .seed = rng.Bits32()};
}

// Wide swells with shallow valleys, some metres of relief about the walk.
void Plain(Rng& rng, TerrainSpec& spec) {
  spec.terms.push_back(Term(rng, TermKind::kHills, {2200, 4200}, {5, 12}, 4));
  spec.terms.push_back(Term(rng, TermKind::kHills, {160, 320}, {0.8, 2.2}, 3));
  // Hills at the edge of sight.
  spec.terms.push_back(Term(rng, TermKind::kBillows, {7000, 12000}, {8, 40}, 5));
  spec.streams = {.steps = 40, .erodibility = 0.3f, .talus = 0.4f, .diffusion = 0.5f};
  spec.rain.droplets = 60'000;
  spec.gravity.passes = 4;
  spec.roughness = 0.55f;
}

// Wooded hills: slopes of 5 to 25 degrees, small valleys with a floor.
void Hills(Rng& rng, TerrainSpec& spec) {
  spec.terms.push_back(Term(rng, TermKind::kHills, {1100, 2000}, {16, 40}, 6));
  spec.terms.push_back(Term(rng, TermKind::kHills, {60, 110}, {1.2, 2.6}, 3));
  spec.terms.push_back(Term(rng, TermKind::kRidges, {8000, 12000}, {25, 90}, 6));
  spec.streams = {.steps = 45, .erodibility = 0.35f, .talus = 0.6f, .diffusion = 0.35f};
  spec.rain.droplets = 120'000;
  spec.gravity.passes = 10;
  spec.roughness = 1.0f;
}

// A range: crests, branching valleys, cliffs over screes.
void Mountains(Rng& rng, TerrainSpec& spec) {
  spec.terms.push_back(Term(rng, TermKind::kRidges, {3200, 5200}, {260, 480}, 3));
  spec.terms.back().warp = 0.3f;
  spec.terms.push_back(Term(rng, TermKind::kHills, {280, 480}, {14, 30}, 5));
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
  spec.terms.push_back(Term(rng, TermKind::kHills, {45, 90}, {0.5, 1.2}, 3));
  spec.terms.push_back(Term(rng, TermKind::kRidges, {6000, 10000}, {30, 110}, 6));
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
  spec.terms.push_back(
      Term(rng, TermKind::kHills, {420, 1000}, sandy ? Range{6, 24} : Range{16, 46}, 5));
  spec.terms.push_back(
      Term(rng, TermKind::kHills, {20, 36}, sandy ? Range{0.9, 1.9} : Range{0.5, 1.2}, 3));
  spec.terms.push_back(Term(rng, TermKind::kRidges, {5000, 8000}, {20, 80}, 6));
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
  spec.terms.push_back(Term(rng, TermKind::kHills, {350, 800}, {3, 11}, 5));
  spec.terms.push_back({.kind = TermKind::kDunes,
                        .wavelength_m = Draw(rng, 11, 20),
                        .amplitude_m = Draw(rng, 0.12, 0.3),
                        .octaves = 1,
                        .sharpness = 0.75f,
                        .direction_rad = Draw(rng, -3.14, 3.14),
                        .seed = rng.Bits32()});
  spec.terms.push_back(Term(rng, TermKind::kHills, {40, 90}, {0.5, 1.3}, 3));
  spec.terms.push_back(Term(rng, TermKind::kRidges, {4500, 8000}, {25, 110}, 6));
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

float Direction(Rng& rng) { return Draw(rng, 0, 2 * std::numbers::pi); }

// Low swells that wind and rare floods left.
void Lowland(Rng& rng, double rough_m, TerrainSpec& spec) {
  spec.terms.push_back(Term(rng, TermKind::kHills, {1500, 3000}, {3, 9}, 4));
  spec.terms.push_back({.kind = TermKind::kHills,
                        .wavelength_m = Draw(rng, 70, 160),
                        .amplitude_m = static_cast<float>(rough_m) * Draw(rng, 0.7, 1.4),
                        .octaves = 4,
                        .seed = rng.Bits32()});
  spec.streams = {.steps = 30, .erodibility = 0.3f, .talus = 0.6f, .diffusion = 0.3f};
  spec.rain.droplets = 60'000;
  spec.gravity.passes = 6;
}

// A sea of sand: large dunes, small ones on their backs, all from one wind.
void SandSea(Rng& rng, TerrainSpec& spec) {
  Lowland(rng, 0.7, spec);
  spec.rain.droplets = 0;
  const float wind = Direction(rng);
  const float length = Draw(rng, 90, 210);
  spec.cover.push_back({.kind = TermKind::kDunes,
                        .wavelength_m = length,
                        .amplitude_m = length * Draw(rng, 0.03, 0.055),
                        .warp = Draw(rng, 0.18, 0.4),
                        .direction_rad = wind,
                        .seed = rng.Bits32()});
  spec.cover.push_back({.kind = TermKind::kDunes,
                        .wavelength_m = Draw(rng, 17, 30),
                        .amplitude_m = Draw(rng, 0.25, 0.6),
                        .warp = 0.45f,
                        .direction_rad = wind + Draw(rng, -0.4, 0.4),
                        .seed = rng.Bits32()});
  spec.roughness = 0.08f;
}

// A plain of stones below mesas.
void StonyDesert(Rng& rng, TerrainSpec& spec) {
  Lowland(rng, 1.6, spec);
  spec.terms.push_back(Term(rng, TermKind::kPlateau, {900, 1700}, {18, 55}, 4));
  spec.terms.back().sharpness = 0.9f;
  spec.terms.push_back(Term(rng, TermKind::kRidges, {5000, 9000}, {60, 200}, 6));
  spec.streams = {.steps = 35, .erodibility = 0.3f, .talus = 0.8f, .diffusion = 0.12f};
  spec.rain.droplets = 140'000;
  spec.gravity.passes = 14;
  spec.strata = {.bed_m = Draw(rng, 5, 11),
                 .step = Draw(rng, 0.6, 0.85),
                 .ledge_m = 0.9f,
                 .dip = Draw(rng, 0, 0.03),
                 .dip_rad = Direction(rng),
                 .seed = rng.Bits32()};
  spec.roughness = 0.9f;
}

void Desert(Rng& rng, TerrainSpec& spec) {
  rng.Bernoulli(0.42) ? SandSea(rng, spec) : StonyDesert(rng, spec);
}

// A river's valley in bedded rock: steps, walls, screes, a floor to walk on.
void Canyon(Rng& rng, TerrainSpec& spec) {
  spec.terms.push_back(Term(rng, TermKind::kHills, {1200, 2400}, {8, 20}, 5));
  spec.terms.push_back(Term(rng, TermKind::kHills, {60, 120}, {1.0, 2.2}, 4));
  const float depth = Draw(rng, 70, 150);
  spec.cover.push_back({.kind = TermKind::kGorge,
                        .wavelength_m = Draw(rng, 260, 480),
                        .amplitude_m = depth,
                        .warp = Draw(rng, 0.16, 0.3),
                        .sharpness = Draw(rng, 0.25, 0.55),
                        .direction_rad = Direction(rng),
                        .width_m = Draw(rng, 30, 70),
                        .seed = rng.Bits32()});
  spec.streams = {.steps = 35, .erodibility = 0.35f, .talus = 0.7f, .diffusion = 0.2f};
  spec.rain.droplets = 120'000;
  spec.gravity.passes = 10;
  spec.strata = {.bed_m = Draw(rng, 11, 24),
                 .step = Draw(rng, 0.75, 0.95),
                 .ledge_m = Draw(rng, 1.0, 1.9),
                 .dip = Draw(rng, 0, 0.025),
                 .dip_rad = Direction(rng),
                 .seed = rng.Bits32()};
  spec.roughness = 1.1f;
}

// A wall of rock between two levels, with debris at its foot.
void Cliff(Rng& rng, TerrainSpec& spec) {
  spec.terms.push_back(Term(rng, TermKind::kHills, {900, 1700}, {8, 20}, 5));
  spec.terms.push_back(Term(rng, TermKind::kHills, {60, 120}, {1.2, 2.6}, 4));
  spec.terms.push_back(Term(rng, TermKind::kRidges, {6000, 9000}, {30, 120}, 6));
  const float height = Draw(rng, 35, 85);
  spec.cover.push_back({.kind = TermKind::kScarp,
                        .wavelength_m = Draw(rng, 180, 360),
                        .amplitude_m = height,
                        .warp = Draw(rng, 0.2, 0.38),
                        .sharpness = Draw(rng, 0.3, 0.8),
                        .direction_rad = Direction(rng),
                        .width_m = height * Draw(rng, 0.12, 0.3),
                        .seed = rng.Bits32()});
  spec.streams = {.steps = 40, .erodibility = 0.35f, .talus = 0.6f, .diffusion = 0.3f};
  spec.rain.droplets = 140'000;
  spec.gravity.passes = 10;
  spec.strata = {.bed_m = Draw(rng, 7, 15),
                 .step = Draw(rng, 0.35, 0.7),
                 .ledge_m = Draw(rng, 1.2, 2.2),
                 .dip = Draw(rng, 0, 0.1),
                 .dip_rad = Direction(rng),
                 .seed = rng.Bits32()};
  spec.roughness = 1.2f;
}

// Mountains under snow.
void SnowyMountains(Rng& rng, TerrainSpec& spec) {
  Mountains(rng, spec);
  spec.snow = {.depth_m = Draw(rng, 0.35, 0.9),
               .line_m = -2000,
               .line_soft_m = 100,
               .slope = Draw(rng, 0.6, 0.8),
               .wind_rad = Direction(rng)};
}

// A narrow gorge below a hill, which a roof makes a cave.
void Cave(Rng& rng, TerrainSpec& spec) {
  spec.terms.push_back(Term(rng, TermKind::kHills, {500, 900}, {2, 5}, 4));
  spec.terms.push_back(Term(rng, TermKind::kHills, {14, 26}, {0.25, 0.5}, 4));
  spec.cover.push_back({.kind = TermKind::kGorge,
                        .wavelength_m = Draw(rng, 50, 80),
                        .amplitude_m = Draw(rng, 17, 22),
                        .warp = Draw(rng, 0.14, 0.22),
                        .sharpness = 0.9f,
                        .direction_rad = Direction(rng),
                        .width_m = Draw(rng, 11, 17),
                        .seed = rng.Bits32()});
  spec.streams = {.steps = 10, .erodibility = 0.2f, .talus = 0.6f, .diffusion = 0.5f};
  spec.rain.droplets = 20'000;
  spec.gravity.passes = 4;
  spec.strata = {.bed_m = Draw(rng, 2.2, 4),
                 .step = 0.25f,
                 .ledge_m = Draw(rng, 0.9, 1.5),
                 .dip = Draw(rng, 0, 0.1),
                 .dip_rad = Direction(rng),
                 .seed = rng.Bits32()};
  spec.roughness = 1.0f;
}

struct Landform {
  std::string_view name;
  void (*draw)(Rng& rng, TerrainSpec& spec);
};
constexpr Landform kLandforms[] = {{"arctic", Arctic},
                                   {"canyon", Canyon},
                                   {"cave", Cave},
                                   {"cliff", Cliff},
                                   {"coast", Coast},
                                   {"desert", Desert},
                                   {"hills", Hills},
                                   {"mountains", Mountains},
                                   {"plain", Plain},
                                   {"river", River},
                                   {"snowy mountains", SnowyMountains}};

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
  return InvalidArgument("there is no landform \"{}\": allowed are {}", name, known);
}

}  // namespace parallax
