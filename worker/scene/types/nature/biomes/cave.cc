#include <cmath>

#include "worker/scene/types/nature/biomes/shared.h"
#include "worker/scene/types/nature/nature.h"
#include "worker/scene/types/nature/rules/recipe.h"

namespace parallax {
namespace {

std::vector<std::string> CaveGround(const std::string&) {
  return {"Gravel", "Soil", "CaveRock", "ForestFloor", "CaveRock"};
}

void AddRoof(const TerrainSpec& spec, Rng& rng, v1::Terrain& recipe) {
  const TerrainTerm& gorge = spec.cover.front();
  v1::CaveRoof& roof = *recipe.mutable_roof();
  roof.set_rise_m(rng.Uniform(6.5, 10));
  roof.set_spring_m(rng.Uniform(1.8, 3));
  roof.set_reach_m(0.82 * static_cast<double>(gorge.width_m) + 8);
  roof.set_half_length_m(rng.Uniform(40, 54));
  roof.set_object_index(kRoofIndex);
  roof.set_seed(rng.Bits32());
  const int holes = rng.UniformInt(2, 4);
  for (int i = 0; i < holes; ++i) {
    const double along =
        roof.half_length_m() * (2 * (i + rng.Uniform(0.25, 0.75)) / holes - 1) * 0.9;
    const Vec2f middle = GorgeMiddle(gorge, static_cast<float>(along));
    const double half = static_cast<double>(PlaceInGorge(gorge, middle).half_m);
    v1::CaveRoof::Skylight& hole = *roof.add_skylights();
    hole.set_x_m(static_cast<double>(middle.x()) + 0.5 * half * rng.Uniform(-1, 1));
    hole.set_y_m(static_cast<double>(middle.y()) + 0.5 * half * rng.Uniform(-1, 1));
    hole.set_radius_m(rng.Uniform(1.2, 2.8));
  }
}

// Standing on the floor.
void AddStalagmites(LayerWriter& w, Rng& rng) {
  AddBlocks(w,
            {"columns", "DripstoneColumn", 4, rng.Uniform(0.006, 0.018), 2.2, 90, 1.15, 1.7, 1, 0.3,
             0.7, false},
            {.slope = kWalkable, .patches_m = 13, .cover = 0.55, .soft = 0.15});
  AddBlocks(w,
            {"stalagmites", "Stalagmites", 6, rng.Uniform(0.05, 0.14), 0.9, 90, 0.5, 1.7, 1, 0.08,
             0.5, false},
            {.slope = {0, 0.9, 0.2}, .patches_m = 8, .cover = 0.5, .soft = 0.15});
}

// Hanging from the roof.
void AddStalactites(LayerWriter& w, Rng& rng) {
  w.Add({.name = "stalactites",
         .asset = "Stalactites",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 6,
         .each = true,
         .per_m2 = rng.Uniform(0.12, 0.3),
         .spacing_m = 0.6,
         .reach_m = 90,
         .low = 0.6,
         .high = 2.0,
         .sink_m = 0.12,
         .claim_m = 0.5,
         .hangs = true,
         .mask = {.patches_m = 7, .cover = 0.6, .soft = 0.2}});
  w.Add({.name = "small stalactites",
         .asset = "Stalactites",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 6,
         .per_m2 = 1.3,
         .spacing_m = 0.4,
         .reach_m = 60,
         .low = 0.15,
         .high = 0.6,
         .sink_m = 0.1,
         .claim_m = 0.4,
         .hangs = true,
         .mask = {.patches_m = 4, .cover = 0.5, .soft = 0.2}});
}

void AddCaveStones(LayerWriter& w, Rng& rng, const MaskSpec::Range& below) {
  AddRubble(w, rng.Uniform(0.5, 1.0), {.slope = {0, 0.8, 0.2}, .height_m = below});
  AddCover(w, {"pebbles", "Pebbles", 8, 5, 26, 0.8, 2.4, 0.1, 0.008},
           {.height_m = below, .patches_m = 6, .cover = 0.5, .soft = 0.2}, Matter::kStones);
}

void AddHillPlants(LayerWriter& w, const MaskSpec::Range& above) {
  const TreeKind kind{"oaks", "BroadleafTree/oak", 3.6, 0.02, 4, 300, 0.5, 1.0};
  AddTrees(w, kind,
           {.slope = kWalkable, .height_m = above, .patches_m = 40, .cover = 0.5, .soft = 0.1});
  AddPlant(w,
           {"bushes", w.bare() ? "DryBush" : "Shrub", 4, 0.08, 1.2, 160, 0.4, 1.2, 0.04, 0.35, 0.6},
           {.slope = {0, 0.9, 0.2}, .height_m = above, .patches_m = 12, .cover = 0.6, .soft = 0.1});
}

// Plants in the light of the skylights.
void AddSkylightPlants(LayerWriter& w, const MaskSpec::Range& below) {
  AddCover(w, {"ferns", "FernPlant", 5, 0.5, 50, 0.35, 0.9, 0.7, 0.01, 0.35},
           {.slope = {0, 1.0, 0.3}, .patches_m = 9, .cover = 0.15, .soft = 0.08});
  AddCover(w, {"mushrooms", "Mushrooms", 5, 0.3, 16, 0.7, 1.5, 1, 0.004},
           {.slope = kWalkable, .height_m = below, .patches_m = 5, .cover = 0.25, .soft = 0.05});
}

void WriteCave(BiomeDraft& draft) {
  LayerWriter w(draft);
  Rng rng = w.Stream("cave");
  const auto spec = TerrainSpecOf(draft.recipe);
  if (!spec.ok() || spec->cover.empty()) return;  // CheckRules names what is wrong.
  AddRoof(*spec, rng, draft.recipe);
  // The hill above: a height that the gorge's floor does not reach.
  const double hill = static_cast<double>(draft.heights.middle_m) - 6;
  const MaskSpec::Range above = {hill, 9000, 2}, below = {-9000, hill, 2};
  w.AddGround({});
  w.AddGround({.patches_m = 6, .cover = rng.Uniform(0.2, 0.5), .soft = 0.15});
  w.AddGround({.patches_m = 8, .cover = rng.Uniform(0.3, 0.6), .soft = 0.15});
  w.AddGround({.slope = {0, 0.9, 0.2}, .height_m = above});
  w.AddGround({.slope = {0.6, 99, 0.15}});
  AddStalagmites(w, rng);
  AddStalactites(w, rng);
  AddCaveStones(w, rng, below);
  AddHillPlants(w, above);
  AddSkylightPlants(w, below);
}

}  // namespace

const Biome kCave = {
    .name = "cave",
    .landform = "cave",
    .weight = [](const v1::BiomeWeights& weights) { return weights.cave(); },
    .ground = &CaveGround,
    .write = &WriteCave,
    .trace_times = 1.8,
};

}  // namespace parallax
