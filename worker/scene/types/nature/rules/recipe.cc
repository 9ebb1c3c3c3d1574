#include "worker/scene/types/nature/rules/recipe.h"

#include <fmt/core.h>

#include <cmath>
#include <mutex>
#include <string>
#include <utility>

#include "worker/scene/types/nature/rules/plot.h"

namespace parallax {
namespace {

absl::Status Bad(const std::string& what) { return InvalidArgument("terrain: {}", what); }

absl::Status CheckNumber(const char* name, double value, double low, double high) {
  if (value >= low && value <= high) return absl::OkStatus();  // False for NaN.
  return Bad(fmt::format("{} is {:f}, allowed is {:f} to {:f}", name, value, low, high));
}

absl::StatusOr<TerrainTerm> TermOf(const v1::TerrainTerm& term) {
  TerrainTerm made;
  ASSIGN_OR_RETURN(made.kind, ParseTermKind(term.kind()));
  RETURN_IF_ERROR(CheckNumber("wavelength_m", term.wavelength_m(), 1, 1e6));
  RETURN_IF_ERROR(CheckNumber("amplitude_m", term.amplitude_m(), -5000, 5000));
  RETURN_IF_ERROR(CheckNumber("octaves", term.octaves(), 1, 16));
  RETURN_IF_ERROR(CheckNumber("gain", term.gain(), 0, 1));
  RETURN_IF_ERROR(CheckNumber("warp", term.warp(), 0, 4));
  RETURN_IF_ERROR(CheckNumber("sharpness", term.sharpness(), 0, 1));
  RETURN_IF_ERROR(CheckNumber("direction_rad", term.direction_rad(), -10, 10));
  RETURN_IF_ERROR(CheckNumber("width_m", term.width_m(), 0, 10'000));
  if (made.kind == TermKind::kGorge || made.kind == TermKind::kScarp ||
      made.kind == TermKind::kDunes) {
    RETURN_IF_ERROR(CheckNumber("amplitude_m of walls and dunes", term.amplitude_m(), 0.01, 5000));
  }
  made.wavelength_m = static_cast<float>(term.wavelength_m());
  made.amplitude_m = static_cast<float>(term.amplitude_m());
  made.octaves = term.octaves();
  made.gain = static_cast<float>(term.gain());
  made.warp = static_cast<float>(term.warp());
  made.sharpness = static_cast<float>(term.sharpness());
  made.direction_rad = static_cast<float>(term.direction_rad());
  made.width_m = static_cast<float>(term.width_m());
  made.seed = term.seed();
  return made;
}

void SetTerm(const TerrainTerm& term, v1::TerrainTerm& made) {
  made.set_kind(std::string(TermKindName(term.kind)));
  made.set_wavelength_m(term.wavelength_m);
  made.set_amplitude_m(term.amplitude_m);
  made.set_octaves(term.octaves);
  made.set_gain(term.gain);
  made.set_warp(term.warp);
  made.set_sharpness(term.sharpness);
  made.set_direction_rad(term.direction_rad);
  made.set_width_m(term.width_m);
  made.set_seed(term.seed);
}

void SetStrata(const StrataSpec& spec, v1::Terrain& recipe) {
  if (spec.bed_m <= 0) return;
  v1::Strata& made = *recipe.mutable_strata();
  made.set_bed_m(spec.bed_m);
  made.set_step(spec.step);
  made.set_ledge_m(spec.ledge_m);
  made.set_dip(spec.dip);
  made.set_dip_rad(spec.dip_rad);
  made.set_seed(spec.seed);
}

void SetSnow(const SnowSpec& spec, v1::Terrain& recipe) {
  if (spec.depth_m <= 0) return;
  v1::Snow& made = *recipe.mutable_snow();
  made.set_depth_m(spec.depth_m);
  made.set_line_m(spec.line_m);
  made.set_line_soft_m(spec.line_soft_m);
  made.set_slope(spec.slope);
  made.set_wind_rad(spec.wind_rad);
}

absl::StatusOr<StrataSpec> StrataOf(const v1::Terrain& recipe) {
  StrataSpec made;
  if (!recipe.has_strata()) return made;
  const v1::Strata& strata = recipe.strata();
  RETURN_IF_ERROR(CheckNumber("strata.bed_m", strata.bed_m(), 0.2, 1000));
  RETURN_IF_ERROR(CheckNumber("strata.step", strata.step(), 0, 1));
  RETURN_IF_ERROR(CheckNumber("strata.ledge_m", strata.ledge_m(), 0, 20));
  RETURN_IF_ERROR(CheckNumber("strata.dip", strata.dip(), -1, 1));
  RETURN_IF_ERROR(CheckNumber("strata.dip_rad", strata.dip_rad(), -10, 10));
  made.bed_m = static_cast<float>(strata.bed_m());
  made.step = static_cast<float>(strata.step());
  made.ledge_m = static_cast<float>(strata.ledge_m());
  made.dip = static_cast<float>(strata.dip());
  made.dip_rad = static_cast<float>(strata.dip_rad());
  made.seed = strata.seed();
  return made;
}

absl::StatusOr<SnowSpec> SnowOf(const v1::Terrain& recipe) {
  SnowSpec made;
  if (!recipe.has_snow()) return made;
  const v1::Snow& snow = recipe.snow();
  RETURN_IF_ERROR(CheckNumber("snow.depth_m", snow.depth_m(), 0.01, 20));
  RETURN_IF_ERROR(CheckNumber("snow.line_m", snow.line_m(), -1e4, 1e4));
  RETURN_IF_ERROR(CheckNumber("snow.line_soft_m", snow.line_soft_m(), 0.01, 1e4));
  RETURN_IF_ERROR(CheckNumber("snow.slope", snow.slope(), 0.05, 10));
  RETURN_IF_ERROR(CheckNumber("snow.wind_rad", snow.wind_rad(), -10, 10));
  made.depth_m = static_cast<float>(snow.depth_m());
  made.line_m = static_cast<float>(snow.line_m());
  made.line_soft_m = static_cast<float>(snow.line_soft_m());
  made.slope = static_cast<float>(snow.slope());
  made.wind_rad = static_cast<float>(snow.wind_rad());
  return made;
}

absl::Status CheckErosion(const v1::Erosion& e) {
  RETURN_IF_ERROR(CheckNumber("stream_steps", e.stream_steps(), 0, 400));
  RETURN_IF_ERROR(CheckNumber("erodibility", e.erodibility(), 0, 100));
  RETURN_IF_ERROR(CheckNumber("area_exponent", e.area_exponent(), 0, 2));
  RETURN_IF_ERROR(CheckNumber("stream_talus", e.stream_talus(), 0.01, 100));
  RETURN_IF_ERROR(CheckNumber("diffusion", e.diffusion(), 0, 1));
  RETURN_IF_ERROR(CheckNumber("droplets", e.droplets(), 0, 3e6));
  RETURN_IF_ERROR(CheckNumber("inertia", e.inertia(), 0, 1));
  RETURN_IF_ERROR(CheckNumber("capacity", e.capacity(), 0, 100));
  RETURN_IF_ERROR(CheckNumber("erosion", e.erosion(), 0, 1));
  RETURN_IF_ERROR(CheckNumber("deposition", e.deposition(), 0, 1));
  RETURN_IF_ERROR(CheckNumber("evaporation", e.evaporation(), 0, 1));
  RETURN_IF_ERROR(CheckNumber("lifetime", e.lifetime(), 0, 1000));
  RETURN_IF_ERROR(CheckNumber("gravity_passes", e.gravity_passes(), 0, 400));
  RETURN_IF_ERROR(CheckNumber("talus", e.talus(), 0.01, 100));
  RETURN_IF_ERROR(CheckNumber("hardness_low", e.hardness_low(), 0, 100));
  RETURN_IF_ERROR(CheckNumber("hardness_high", e.hardness_high(), 0, 100));
  return CheckNumber("band_m", e.band_m(), 0.1, 1e5);
}

absl::StatusOr<WaterSpec> WaterSpecOf(const v1::Water& water) {
  WaterSpec spec;
  ASSIGN_OR_RETURN(spec.kind, ParseWaterKind(water.kind()));
  RETURN_IF_ERROR(CheckNumber("water.direction_rad", water.direction_rad(), -10, 10));
  RETURN_IF_ERROR(CheckNumber("water.level_m", water.level_m(), -5000, 5000));
  RETURN_IF_ERROR(CheckNumber("water.fall", water.fall(), 0, 0.2));
  RETURN_IF_ERROR(CheckNumber("water.bend_m", water.bend_m(), 20, 1e5));
  RETURN_IF_ERROR(CheckNumber("water.swing_m", water.swing_m(), 0, 0.2 * water.bend_m()));
  RETURN_IF_ERROR(CheckNumber("water.width_m", water.width_m(), 1, 500));
  RETURN_IF_ERROR(CheckNumber("water.depth_m", water.depth_m(), 0.05, 200));
  RETURN_IF_ERROR(CheckNumber("water.slope", water.slope(), 0.02, 3));
  RETURN_IF_ERROR(CheckNumber("water.bank_m", water.bank_m(), 0.3, 100));
  RETURN_IF_ERROR(CheckNumber("water.plain_m", water.plain_m(), 5, 2000));
  RETURN_IF_ERROR(CheckNumber("water.wind_mps", water.wind_mps(), 0, 20));
  RETURN_IF_ERROR(CheckNumber("water.wind_rad", water.wind_rad(), -10, 10));
  RETURN_IF_ERROR(CheckNumber("water.clarity_m", water.clarity_m(), 0.02, 40));
  spec.direction_rad = static_cast<float>(water.direction_rad());
  spec.level_m = static_cast<float>(water.level_m());
  spec.fall = static_cast<float>(water.fall());
  spec.bend_m = static_cast<float>(water.bend_m());
  spec.swing_m = static_cast<float>(water.swing_m());
  spec.width_m = static_cast<float>(water.width_m());
  spec.depth_m = static_cast<float>(water.depth_m());
  spec.slope = static_cast<float>(water.slope());
  spec.bank_m = static_cast<float>(water.bank_m());
  spec.plain_m = static_cast<float>(water.plain_m());
  spec.seed = water.seed();
  spec.wind_mps = static_cast<float>(water.wind_mps());
  spec.wind_rad = static_cast<float>(water.wind_rad());
  return spec;
}

void SetWaterSpec(const WaterSpec& spec, v1::Water& water) {
  water.set_kind(std::string(WaterKindName(spec.kind)));
  water.set_direction_rad(spec.direction_rad);
  water.set_level_m(spec.level_m);
  water.set_fall(spec.fall);
  water.set_bend_m(spec.bend_m);
  water.set_swing_m(spec.swing_m);
  water.set_width_m(spec.width_m);
  water.set_depth_m(spec.depth_m);
  water.set_slope(spec.slope);
  water.set_bank_m(spec.bank_m);
  water.set_plain_m(spec.plain_m);
  water.set_seed(spec.seed);
  water.set_wind_mps(spec.wind_mps);
  water.set_wind_rad(spec.wind_rad);
}

absl::Status CheckRange(const std::string& name, const v1::SoftRange& range) {
  constexpr double kMost = 1e6;
  RETURN_IF_ERROR(CheckNumber((name + ".low").c_str(), range.low(), -kMost, kMost));
  RETURN_IF_ERROR(CheckNumber((name + ".high").c_str(), range.high(), -kMost, kMost));
  return CheckNumber((name + ".soft").c_str(), range.soft(), 0, kMost);
}

absl::Status CheckMask(const v1::GroundMask& mask) {
  RETURN_IF_ERROR(CheckRange("mask.slope", mask.slope()));
  RETURN_IF_ERROR(CheckRange("mask.height_m", mask.height_m()));
  RETURN_IF_ERROR(CheckRange("mask.above_water_m", mask.above_water_m()));
  RETURN_IF_ERROR(CheckRange("mask.wetness", mask.wetness()));
  RETURN_IF_ERROR(CheckRange("mask.deposit_m", mask.deposit_m()));
  RETURN_IF_ERROR(CheckRange("mask.shade", mask.shade()));
  RETURN_IF_ERROR(CheckRange("mask.snow_m", mask.snow_m()));
  if (mask.noise_m() != 0) {
    RETURN_IF_ERROR(CheckNumber("mask.noise_m, where it is not 0,", mask.noise_m(), 0.05, 1e5));
  }
  RETURN_IF_ERROR(CheckNumber("mask.noise_cover", mask.noise_cover(), 0, 1));
  RETURN_IF_ERROR(CheckNumber("mask.noise_soft", mask.noise_soft(), 0, 10));
  if (mask.rows_m() == 0) return absl::OkStatus();
  RETURN_IF_ERROR(CheckNumber("mask.rows_m, where it is not 0,", mask.rows_m(), 0.1, 1000));
  RETURN_IF_ERROR(CheckNumber("mask.row_width_m", mask.row_width_m(), 0.01, 1000));
  return CheckNumber("mask.row_direction_rad", mask.row_direction_rad(), -7, 7);
}

absl::Status CheckMasks(const v1::Terrain& recipe) {
  for (const v1::ScatterLayer& layer : recipe.layers()) {
    RETURN_IF_ERROR(WithContext(CheckMask(layer.mask()), "layer \"" + layer.name() + "\""));
  }
  for (int i = 0; i < recipe.ground_size(); ++i) {
    RETURN_IF_ERROR(
        WithContext(CheckMask(recipe.ground(i).mask()), fmt::format("ground rule {}", i)));
  }
  return WithContext(CheckMask(recipe.walk()), "walk");
}

absl::Status CheckLayer(const v1::Terrain& recipe, const v1::ScatterLayer& layer) {
  const auto number = [&](const char* name, double value, double low, double high) {
    return WithContext(CheckNumber(name, value, low, high), "layer \"" + layer.name() + "\"");
  };
  RETURN_IF_ERROR(number("prototypes", layer.prototypes_size(), 1, 16));
  if (layer.weights_size() != layer.prototypes_size()) {
    return Bad(fmt::format("layer \"{}\": weights for {} of its {} prototypes", layer.name(),
                           layer.weights_size(), layer.prototypes_size()));
  }
  if (layer.index_each()) RETURN_IF_ERROR(number("prototypes", layer.prototypes_size(), 1, 1));
  for (const uint32_t prototype : layer.prototypes()) {
    RETURN_IF_ERROR(number("prototype", prototype, 0, recipe.prototypes_size() - 1));
  }
  double weights = 0;
  for (const double weight : layer.weights()) {
    RETURN_IF_ERROR(number("weight", weight, 0, 1e6));
    weights += weight;
  }
  RETURN_IF_ERROR(number("sum of weights", weights, 1e-9, 1e8));
  RETURN_IF_ERROR(number("per_m2", layer.per_m2(), 0, kMostPerM2));
  RETURN_IF_ERROR(number("spacing_m", layer.spacing_m(), 0, 12));
  RETURN_IF_ERROR(number("reach_m", layer.reach_m(), 0, 3000));
  RETURN_IF_ERROR(number("size_low", layer.size_low(), 0.01, 15));
  RETURN_IF_ERROR(number("size_high", layer.size_high(), layer.size_low(), 15));
  if (layer.mask().rows_m() > 0 && layer.spacing_m() > 0) {
    const double step_m = 0.5 * layer.spacing_m() * (layer.size_low() + layer.size_high());
    RETURN_IF_ERROR(number("spacing_m in rows, times the mean size,", step_m, 1e-3, 180));
  }
  RETURN_IF_ERROR(number("upright", layer.upright(), 0, 1));
  RETURN_IF_ERROR(number("sink_m", layer.sink_m(), -1, 10));
  RETURN_IF_ERROR(number("claim_m", layer.claim_m(), 0, 8));
  RETURN_IF_ERROR(number("crown_m", layer.crown_m(), 0, 12));
  RETURN_IF_ERROR(number("near_parents_m", layer.near_parents_m(), 0, 14));
  if (layer.hangs() && !recipe.has_roof()) {
    return Bad("layer \"" + layer.name() + "\" hangs, but there is no roof");
  }
  return number("first_object_index", layer.first_object_index(), 0, 65535);
}

absl::Status CheckRoof(const v1::Terrain& recipe) {
  const v1::CaveRoof& roof = recipe.roof();
  if (recipe.cover().empty() || recipe.cover(0).kind() != TermKindName(TermKind::kGorge)) {
    return Bad("a roof needs a gorge, the first of cover");
  }
  RETURN_IF_ERROR(CheckNumber("roof.rise_m", roof.rise_m(), 2, 100));
  RETURN_IF_ERROR(CheckNumber("roof.spring_m", roof.spring_m(), 0.5, roof.rise_m()));
  RETURN_IF_ERROR(CheckNumber("roof.reach_m", roof.reach_m(), 2, 200));
  RETURN_IF_ERROR(CheckNumber("roof.half_length_m", roof.half_length_m(), 5, 500));
  RETURN_IF_ERROR(CheckNumber("roof.skylights", roof.skylights_size(), 0, kMostSkylights));
  for (const v1::CaveRoof::Skylight& hole : roof.skylights()) {
    RETURN_IF_ERROR(CheckNumber("skylight.radius_m", hole.radius_m(), 0.2, 50));
  }
  return CheckNumber("roof.object_index", roof.object_index(), 1, 65535);
}

}  // namespace

void SetTerrainSpec(const TerrainSpec& spec, v1::Terrain& recipe) {
  recipe.set_seed(spec.seed);
  for (const TerrainTerm& term : spec.terms) SetTerm(term, *recipe.add_terms());
  for (const TerrainTerm& term : spec.cover) SetTerm(term, *recipe.add_cover());
  SetStrata(spec.strata, recipe);
  SetSnow(spec.snow, recipe);
  recipe.set_region_m(spec.region_m);
  recipe.set_region_samples(spec.region_samples);
  recipe.set_site_m(spec.site_m);
  recipe.set_site_samples(spec.site_samples);
  v1::Erosion& e = *recipe.mutable_erosion();
  e.set_stream_steps(spec.streams.steps);
  e.set_erodibility(spec.streams.erodibility);
  e.set_area_exponent(spec.streams.area_exponent);
  e.set_stream_talus(spec.streams.talus);
  e.set_diffusion(spec.streams.diffusion);
  e.set_droplets(spec.rain.droplets);
  e.set_inertia(spec.rain.inertia);
  e.set_capacity(spec.rain.capacity);
  e.set_erosion(spec.rain.erosion);
  e.set_deposition(spec.rain.deposition);
  e.set_evaporation(spec.rain.evaporation);
  e.set_lifetime(spec.rain.lifetime);
  e.set_gravity_passes(spec.gravity.passes);
  e.set_talus(spec.gravity.talus);
  e.set_hardness_low(spec.gravity.hardness_low);
  e.set_hardness_high(spec.gravity.hardness_high);
  e.set_band_m(spec.gravity.band_m);
  recipe.set_roughness(spec.roughness);
  if (spec.water) SetWaterSpec(*spec.water, *recipe.mutable_water());
}

absl::StatusOr<TerrainSpec> TerrainSpecOf(const v1::Terrain& recipe) {
  TerrainSpec spec;
  spec.seed = recipe.seed();
  RETURN_IF_ERROR(CheckNumber("terms", recipe.terms_size(), 1, 16));
  for (const v1::TerrainTerm& term : recipe.terms()) {
    ASSIGN_OR_RETURN(spec.terms.emplace_back(), TermOf(term));
  }
  RETURN_IF_ERROR(CheckNumber("cover", recipe.cover_size(), 0, 8));
  for (const v1::TerrainTerm& term : recipe.cover()) {
    ASSIGN_OR_RETURN(spec.cover.emplace_back(), TermOf(term));
  }
  ASSIGN_OR_RETURN(spec.strata, StrataOf(recipe));
  ASSIGN_OR_RETURN(spec.snow, SnowOf(recipe));
  RETURN_IF_ERROR(CheckNumber("region_samples", recipe.region_samples(), 16, 2049));
  RETURN_IF_ERROR(CheckNumber("site_samples", recipe.site_samples(), 16, 2049));
  RETURN_IF_ERROR(CheckNumber("region_m", recipe.region_m(), 100, 1e5));
  RETURN_IF_ERROR(CheckNumber("site_m", recipe.site_m(), 50, recipe.region_m()));
  RETURN_IF_ERROR(CheckNumber("roughness", recipe.roughness(), 0, 20));
  RETURN_IF_ERROR(CheckErosion(recipe.erosion()));
  spec.region_m = static_cast<float>(recipe.region_m());
  spec.region_samples = recipe.region_samples();
  spec.site_m = static_cast<float>(recipe.site_m());
  spec.site_samples = recipe.site_samples();
  const v1::Erosion& e = recipe.erosion();
  spec.streams.steps = e.stream_steps();
  spec.streams.erodibility = static_cast<float>(e.erodibility());
  spec.streams.area_exponent = static_cast<float>(e.area_exponent());
  spec.streams.talus = static_cast<float>(e.stream_talus());
  spec.streams.diffusion = static_cast<float>(e.diffusion());
  spec.rain.droplets = e.droplets();
  spec.rain.inertia = static_cast<float>(e.inertia());
  spec.rain.capacity = static_cast<float>(e.capacity());
  spec.rain.erosion = static_cast<float>(e.erosion());
  spec.rain.deposition = static_cast<float>(e.deposition());
  spec.rain.evaporation = static_cast<float>(e.evaporation());
  spec.rain.lifetime = e.lifetime();
  spec.gravity.passes = e.gravity_passes();
  spec.gravity.talus = static_cast<float>(e.talus());
  spec.gravity.hardness_low = static_cast<float>(e.hardness_low());
  spec.gravity.hardness_high = static_cast<float>(e.hardness_high());
  spec.gravity.band_m = static_cast<float>(e.band_m());
  spec.roughness = static_cast<float>(recipe.roughness());
  if (recipe.has_water()) {
    ASSIGN_OR_RETURN(spec.water, WaterSpecOf(recipe.water()));
  }
  return spec;
}

absl::StatusOr<std::shared_ptr<const Terrain>> TerrainOf(const v1::Terrain& recipe) {
  ASSIGN_OR_RETURN(const TerrainSpec spec, TerrainSpecOf(recipe));
  v1::Terrain only_spec;
  SetTerrainSpec(spec, only_spec);
  const std::string key = only_spec.SerializeAsString();
  static std::mutex& mutex = *new std::mutex;
  static std::string& newest_key = *new std::string;
  static std::shared_ptr<const Terrain>& newest = *new std::shared_ptr<const Terrain>;
  {
    std::lock_guard<std::mutex> lock(mutex);
    if (newest && newest_key == key) return newest;
  }
  auto made = std::make_shared<const Terrain>(MakeTerrain(spec));
  std::lock_guard<std::mutex> lock(mutex);
  newest_key = key;
  newest = made;
  return made;
}

absl::Status CheckRules(const v1::Terrain& recipe) {
  RETURN_IF_ERROR(CheckNumber("layers", recipe.layers_size(), 0, 64));
  RETURN_IF_ERROR(CheckNumber("prototypes", recipe.prototypes_size(), 0, 128));
  RETURN_IF_ERROR(CheckNumber("ground rules", recipe.ground_size(), 1, 12));
  for (const v1::Prototype& prototype : recipe.prototypes()) {
    RETURN_IF_ERROR(CheckNumber("shapes", prototype.shapes(), 1, 16));
    RETURN_IF_ERROR(CheckNumber("snow_m", prototype.snow_m(), 0, 2));
  }
  for (const v1::ScatterLayer& layer : recipe.layers()) {
    RETURN_IF_ERROR(CheckLayer(recipe, layer));
  }
  RETURN_IF_ERROR(CheckMasks(recipe));
  RETURN_IF_ERROR(CheckNumber("clearance_m", recipe.clearance_m(), 0, 10));
  RETURN_IF_ERROR(CheckNumber("clearance_baseline_m", recipe.clearance_baseline_m(), 0, 100));
  if (recipe.has_plot()) RETURN_IF_ERROR(CheckPlot(recipe.plot()));
  return recipe.has_roof() ? CheckRoof(recipe) : absl::OkStatus();
}

}  // namespace parallax
