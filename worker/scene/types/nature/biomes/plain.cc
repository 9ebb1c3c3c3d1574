#include <array>

#include "worker/scene/types/nature/biomes/shared.h"

namespace parallax {
namespace {

std::vector<std::string> PlainGround(const std::string&) {
  return {"ForestFloor", "Soil", "Gravel", "Rock"};
}

constexpr MaskSpec::Range kOpen = {0, 0.75, 0.15};  // Shade of ground below no crown.

// In the order of PlainGround: grown over, soil, gravel, rock.
void AddPlainGround(LayerWriter& w) {
  w.AddGround({});
  w.AddGround({.patches_m = 5.5, .cover = 0.3, .soft = 0.2});
  w.AddGround({.patches_m = 14, .cover = 0.07, .soft = 0.1});
  w.AddGround({.slope = kSteep});
}

// Groves of one kind, and now and then some of another.
void AddGroves(LayerWriter& w, Rng& rng) {
  const std::array<TreeKind, 4> kinds = {{
      {"oaks", "BroadleafTree/oak", 3.6, 0.012, 5.5, 1100, 0.75, 1.5},
      {"maples", "BroadleafTree/maple", 3.1, 0.012, 5, 1100, 0.7, 1.4},
      {"birches", "BroadleafTree/birch", 2.2, 0.02, 3, 1100, 0.7, 1.35},
      {"acacias", "BroadleafTree/acacia", 3.6, 0.008, 6, 1100, 0.8, 1.4},
  }};
  const size_t first = static_cast<size_t>(rng.UniformInt(0, 3));
  const double cover = rng.Uniform(0.04, 0.2);
  const MaskSpec groves = {
      .slope = kWalkable, .patches_m = rng.Uniform(70, 150), .cover = cover, .soft = 0.05};
  AddTrees(w, kinds[first], groves);
  AddSaplings(w, kinds[first], {.slope = kWalkable, .patches_m = 70, .cover = 0.2, .soft = 0.1});
  if (rng.Bernoulli(0.5)) {
    AddTrees(w, kinds[(first + 1) % 3],
             {.slope = kWalkable, .patches_m = 90, .cover = 0.5 * cover, .soft = 0.05});
  }
}

void AddThickets(LayerWriter& w, Rng& rng) {
  const MaskSpec thickets = {
      .slope = kWalkable, .patches_m = 32, .cover = rng.Uniform(0.08, 0.3), .soft = 0.07};
  AddPlant(w,
           {"bushes", w.bare() ? "DryBush" : "Shrub", 4, 0.05, 1.5, 260, 0.5, 1.5, 0.04, 0.35, 0.8},
           thickets);
  if (w.bare() || !rng.Bernoulli(0.5)) return;
  AddPlant(w, {"flowering bushes", "FlowerBush", 2, 0.02, 1.5, 160, 0.6, 1.2, 0.04, 0.35, 0.8},
           {.slope = kWalkable, .patches_m = 40, .cover = 0.12, .soft = 0.07});
}

void AddPlainGrass(LayerWriter& w, Rng& rng) {
  AddCover(w, {"tussocks", "Tussock", 4, rng.Uniform(0.1, 0.5), 75, 0.6, 1.2, 0.6, 0.02, 0.5},
           {.slope = kWalkable, .shade = kOpen, .patches_m = 17, .cover = 0.45, .soft = 0.1});
  AddCover(
      w, {"meadow", "GrassClump", 6, 3.6, 130, 0.7, 1.35, 0.35, 0.015},
      {.slope = kWalkable, .shade = {0, 0.85, 0.1}, .patches_m = 6.5, .cover = 0.78, .soft = 0.2});
  AddCover(w, {"grass", "GrassTuft", 8, 34, 34, 0.5, 1.2, 0.5, 0.006},
           {.slope = kWalkable, .patches_m = 2.2, .cover = 0.82, .soft = 0.25});
}

void AddPlainFlowers(LayerWriter& w, Rng& rng) {
  if (w.draft().season != "spring" && w.draft().season != "summer") return;
  AddCover(w, {"flowers", "FlowerPlant", 6, rng.Uniform(0.6, 2.4), 45, 0.7, 1.4, 1, 0.004},
           {.slope = kWalkable, .shade = kOpen, .patches_m = 8, .cover = 0.25, .soft = 0.1});
}

void AddPlainLitter(LayerWriter& w) {
  AddCover(w, {"leaves", "LeafLitter", 5, 4, 36, 0.7, 1.3, 0.05, -0.002, 0, 5},
           {.slope = kWalkable});
  AddCover(w, {"twigs", "Twigs", 4, 1.2, 24, 0.7, 1.3, 0.05, 0, 0, 5}, {.slope = kWalkable});
}

void WritePlain(BiomeDraft& draft) {
  LayerWriter w(draft);
  Rng rng = w.Stream("plain");
  AddPlainGround(w);
  AddGroves(w, rng);
  AddThickets(w, rng);
  AddStones(w, rng.Uniform(0.0006, 0.006), 1.0, {.patches_m = 40, .cover = 0.4, .soft = 0.15});
  AddPlainGrass(w, rng);
  AddPlainFlowers(w, rng);
  AddPlainLitter(w);
}

}  // namespace

const Biome kPlain = {
    .name = "plain",
    .landform = "plain",
    .weight = [](const v1::BiomeWeights& weights) { return weights.plain(); },
    .ground = &PlainGround,
    .write = &WritePlain,
    .trace_times = 1.8,
};

}  // namespace parallax
