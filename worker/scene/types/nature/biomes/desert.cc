#include "worker/scene/types/nature/biomes/shared.h"

namespace parallax {
namespace {

std::vector<std::string> DesertGround(const std::string&) {
  return {"DesertSand", "Gravel", "Gravel", "RedStrata"};
}

// Slopes on which sand slides, and those below.
constexpr MaskSpec::Range kFirm = {0, 0.3, 0.15};

// Each plant has bare ground around it, whose water it drinks: large claims and spacings.
void AddCacti(LayerWriter& w, double times, Rng& rng) {
  const auto patches = [&](double patches_m) {
    return MaskSpec{
        .slope = kWalkable, .patches_m = patches_m, .cover = rng.Uniform(0.25, 0.7), .soft = 0.15};
  };
  if (rng.Bernoulli(0.75)) {
    AddPlant(
        w, {"column cacti", "ColumnCactus", 5, 0.009 * times, 3.2, 420, 0.6, 1.35, 0.03, 0.5, 0.7},
        patches(60));
  }
  if (rng.Bernoulli(0.8)) {
    AddPlant(w, {"prickly pears", "PricklyPear", 5, 0.016 * times, 1.6, 200, 0.8, 1.9, 0.03, 0.7},
             patches(22));
  }
  if (rng.Bernoulli(0.7)) {
    AddPlant(w, {"agaves", "Agave", 5, 0.016 * times, 1.5, 180, 0.6, 1.3, 0.03, 0.6}, patches(26));
  }
  if (rng.Bernoulli(0.7)) {
    AddPlant(w, {"barrel cacti", "BarrelCactus", 5, 0.012 * times, 1.2, 120, 0.6, 1.4, 0.03, 0.5},
             patches(18));
  }
}

void AddScrub(LayerWriter& w, double times, Rng& rng) {
  AddPlant(w, {"dry bushes", "DryBush", 5, 0.035 * times, 1.8, 260, 0.25, 0.85, 0.03, 0.5, 0.5},
           {.slope = kFirm, .patches_m = 33, .cover = rng.Uniform(0.25, 0.6), .soft = 0.15});
  AddPlant(w, {"green bushes", "Shrub", 5, 0.012 * times, 2.4, 260, 0.25, 0.7, 0.03, 0.6, 0.5},
           {.slope = kFirm, .patches_m = 45, .cover = rng.Uniform(0.1, 0.45), .soft = 0.15});
  AddCover(w, {"tussocks", "Tussock", 5, 0.16 * times, 90, 0.3, 0.8, 0.7, 0.02, 0.9, 0, 0.3},
           {.slope = kFirm, .patches_m = 15, .cover = rng.Uniform(0.2, 0.5), .soft = 0.15});
  AddCover(w, {"grass", "GrassTuft", 6, 0.9 * times, 32, 0.35, 0.8, 0.5, 0.006},
           {.slope = kFirm, .patches_m = 6, .cover = 0.25, .soft = 0.15});
  AddCover(w, {"twigs", "Twigs", 4, 0.12 * times, 24, 0.7, 1.3, 0.05, 0},
           {.slope = kFirm, .patches_m = 9, .cover = 0.4, .soft = 0.15});
}

// Pebbles that wind laid bare, denser in patches.
void AddPavement(LayerWriter& w, double per_m2, double cover) {
  AddCover(w, {"pebbles", "Pebbles", 8, per_m2, 30, 0.7, 2.4, 0.1, 0.008},
           {.slope = kFirm, .patches_m = 7, .cover = cover, .soft = 0.25}, Matter::kStones);
}

void AddFormation(LayerWriter& w, const char* name, const char* asset, double per_m2, double high) {
  AddBlocks(w, {name, asset, 2, per_m2, 8, 900, 0.5, high, 1, 0.9, 3, false},
            {.slope = {0, 0.7, 0.2}, .patches_m = 110, .cover = 0.3, .soft = 0.15});
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
    AddPlant(w, {"palms", "Palm", 5, 0.012, 3, 700, 0.6, 1.2, 0.03, 0.4, 1.8},
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
