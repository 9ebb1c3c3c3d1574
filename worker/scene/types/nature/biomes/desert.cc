#include "worker/scene/types/nature/biomes/shared.h"

namespace parallax {
namespace {

std::vector<std::string> DesertGround(const std::string&) {
  return {"DesertSand", "Gravel", "Gravel", "RedStrata"};
}

// Slopes on which sand slides, and those below.
constexpr MaskSpec::Range kFirm = {0, 0.3, 0.15};

struct DryPlant {
  const char* name;
  const char* asset;
  double per_m2, spacing_m, reach_m, low, high, claim_m, crown_m;
};

void AddPlant(LayerWriter& w, const DryPlant& plant, const MaskSpec& mask) {
  w.Add({.name = plant.name,
         .asset = plant.asset,
         .shapes = 5,
         .each = true,
         .per_m2 = plant.per_m2,
         .spacing_m = plant.spacing_m,
         .reach_m = plant.reach_m,
         .low = plant.low,
         .high = plant.high,
         .sink_m = 0.03,
         .claim_m = plant.claim_m,
         .crown_m = plant.crown_m,
         .mask = mask});
}

// Each plant has bare ground around it, whose water it drinks: large claims and spacings.
void AddCacti(LayerWriter& w, double times, Rng& rng) {
  const auto patches = [&](double patches_m) {
    return MaskSpec{
        .slope = kWalkable, .patches_m = patches_m, .cover = rng.Uniform(0.25, 0.7), .soft = 0.15};
  };
  if (rng.Bernoulli(0.75)) {
    AddPlant(w, {"column cacti", "ColumnCactus", 0.009 * times, 3.2, 420, 0.6, 1.35, 0.5, 0.7},
             patches(60));
  }
  if (rng.Bernoulli(0.8)) {
    AddPlant(w, {"prickly pears", "PricklyPear", 0.016 * times, 1.6, 200, 0.8, 1.9, 0.7, 0},
             patches(22));
  }
  if (rng.Bernoulli(0.7)) {
    AddPlant(w, {"agaves", "Agave", 0.016 * times, 1.5, 180, 0.6, 1.3, 0.6, 0}, patches(26));
  }
  if (rng.Bernoulli(0.7)) {
    AddPlant(w, {"barrel cacti", "BarrelCactus", 0.012 * times, 1.2, 120, 0.6, 1.4, 0.5, 0},
             patches(18));
  }
}

void AddScrub(LayerWriter& w, double times, Rng& rng) {
  AddPlant(w, {"dry bushes", "DryBush", 0.035 * times, 1.8, 260, 0.25, 0.85, 0.5, 0.5},
           {.slope = kFirm, .patches_m = 33, .cover = rng.Uniform(0.25, 0.6), .soft = 0.15});
  AddPlant(w, {"green bushes", "Shrub", 0.012 * times, 2.4, 260, 0.25, 0.7, 0.6, 0.5},
           {.slope = kFirm, .patches_m = 45, .cover = rng.Uniform(0.1, 0.45), .soft = 0.15});
  w.Add({.name = "tussocks",
         .asset = "Tussock",
         .shapes = 5,
         .per_m2 = 0.16 * times,
         .spacing_m = 0.9,
         .reach_m = 90,
         .low = 0.3,
         .high = 0.8,
         .upright = 0.7,
         .sink_m = 0.02,
         .claim_m = 0.3,
         .mask = {.slope = kFirm, .patches_m = 15, .cover = rng.Uniform(0.2, 0.5), .soft = 0.15}});
  w.Add({.name = "grass",
         .asset = "GrassTuft",
         .shapes = 6,
         .per_m2 = 0.9 * times,
         .reach_m = 32,
         .low = 0.35,
         .high = 0.8,
         .upright = 0.5,
         .sink_m = 0.006,
         .mask = {.slope = kFirm, .patches_m = 6, .cover = 0.25, .soft = 0.15}});
  w.Add({.name = "twigs",
         .asset = "Twigs",
         .shapes = 4,
         .per_m2 = 0.12 * times,
         .reach_m = 24,
         .upright = 0.05,
         .sink_m = 0,
         .mask = {.slope = kFirm, .patches_m = 9, .cover = 0.4, .soft = 0.15}});
}

// Pebbles that wind laid bare, denser in patches.
void AddPavement(LayerWriter& w, double per_m2, double cover) {
  w.Add({.name = "pebbles",
         .asset = "Pebbles",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 8,
         .per_m2 = per_m2,
         .reach_m = 30,
         .low = 0.7,
         .high = 2.4,
         .upright = 0.1,
         .sink_m = 0.008,
         .mask = {.slope = kFirm, .patches_m = 7, .cover = cover, .soft = 0.25}});
}

void AddFormation(LayerWriter& w, const char* name, const char* asset, double per_m2, double high) {
  w.Add({.name = name,
         .asset = asset,
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 2,
         .each = true,
         .per_m2 = per_m2,
         .spacing_m = 8,
         .reach_m = 900,
         .low = 0.5,
         .high = high,
         .sink_m = 0.9,
         .claim_m = 3,
         .mask = {.slope = {0, 0.7, 0.2}, .patches_m = 110, .cover = 0.3, .soft = 0.15}});
}

void WriteSandSea(LayerWriter& w, Rng& rng) {
  w.AddGround({});
  w.AddGround(
      {.slope = {0, 0.08, 0.05}, .patches_m = 35, .cover = rng.Uniform(0.03, 0.15), .soft = 0.3});
  w.AddGround({.slope = {0, 0.05, 0.03}, .patches_m = 12, .cover = 0.1, .soft = 0.1});
  w.AddGround({.slope = {1.1, 99, 0.2}});
  if (rng.Bernoulli(0.4)) AddFormation(w, "pillars", "RockPillar", 0.00006, 1.6);
  AddRubble(w, rng.Uniform(0.02, 0.12), {.slope = {0, 0.4, 0.15}});
  AddScrub(w, rng.Uniform(0.1, 0.5), rng);
  if (rng.Bernoulli(0.3)) {
    AddPlant(w, {"palms", "Palm", 0.012, 3, 700, 0.6, 1.2, 0.4, 1.8},
             {.slope = kFirm, .patches_m = 90, .cover = 0.14, .soft = 0.1});
  }
  AddPavement(w, 2.5, 0.25);
}

void WriteStonyDesert(LayerWriter& w, Rng& rng) {
  w.AddGround({});
  w.AddGround({.patches_m = 11, .cover = rng.Uniform(0.45, 0.8), .soft = 0.25});
  w.AddGround({.slope = {0.3, 0.9, 0.12}, .patches_m = 17, .cover = 0.8, .soft = 0.2});
  w.AddGround({.slope = {0.8, 99, 0.16}});
  if (rng.Bernoulli(0.45)) AddFormation(w, "arches", "RockArch", 0.00003, 1.5);
  if (rng.Bernoulli(0.6)) AddFormation(w, "pillars", "RockPillar", 0.00008, 1.9);
  AddCacti(w, rng.Uniform(0.5, 1.4), rng);
  AddRubble(w, rng.Uniform(0.25, 0.9), {.slope = kLoose});
  AddScrub(w, rng.Uniform(0.6, 1.4), rng);
  AddPavement(w, rng.Uniform(5, 9), 0.7);
}

void WriteDesert(BiomeDraft& draft) {
  LayerWriter w(draft);
  Rng rng = w.Stream("desert");
  draft.recipe.cover().empty() ? WriteStonyDesert(w, rng) : WriteSandSea(w, rng);
}

}  // namespace

const Biome kDesert = {
    .name = "desert",
    .landform = "desert",
    .weight = [](const v1::BiomeWeights& weights) { return weights.desert(); },
    .ground = &DesertGround,
    .write = &WriteDesert,
    .trace_times = 0.5,
};

}  // namespace parallax
