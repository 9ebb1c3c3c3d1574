#include "worker/scene/types/nature/biomes/shared.h"

namespace parallax {
namespace {

std::vector<std::string> ArcticGround(const std::string&) {
  return {"PackedSnow", "Gravel", "SeaIce", "SeaIce"};
}

// Floes near and far: of one break-up, in fields with open water between.
void AddFloes(LayerWriter& w, Rng& rng) {
  const double cover = rng.Uniform(0.3, 0.65), field_m = rng.Uniform(60, 150);
  w.Add({.name = "icebergs",
         .asset = "IceBlock",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 6,
         .each = true,
         .per_m2 = 0.00006,
         .spacing_m = 3,
         .reach_m = 2600,
         .low = 4,
         .high = 14,
         .sink_m = 0.3,
         .claim_m = 1.3,
         .floats = true,
         .mask = {.above_water_m = {-99, -3.5, 1}}});
  w.Add(
      {.name = "floes",
       .asset = "IceFloe",
       .role = v1::OBJECT_ROLE_ROCK,
       .shapes = 8,
       .each = true,
       .per_m2 = 0.05,
       .spacing_m = 2.05,
       .reach_m = 700,
       .low = 0.9,
       .high = 4.5,
       .sink_m = 0.17,
       .claim_m = 1.1,
       .floats = true,
       .mask = {
           .above_water_m = {-99, -0.3, 0.2}, .patches_m = field_m, .cover = cover, .soft = 0.06}});
  w.Add({.name = "brash ice",
         .asset = "IceFloe",
         .role = v1::OBJECT_ROLE_ROCK,
         .shapes = 8,
         .per_m2 = 1.3,
         .spacing_m = 2.1,
         .reach_m = 130,
         .low = 0.12,
         .high = 0.7,
         .sink_m = 0.17,
         .floats = true,
         .mask = {.above_water_m = {-99, -0.1, 0.1}, .patches_m = 30, .cover = 0.5, .soft = 0.12}});
}

// Ice that the sea pushed up the shore, and blocks that lie on land.
void AddShoreIce(LayerWriter& w) {
  AddBlocks(w, {"pressure ice", "IceBlock", 6, 0.09, 0.8, 420, 0.42, 2.3, 0.3, 0.14, 0.6},
            {.above_water_m = {-0.4, 1.1, 0.3}, .patches_m = 26, .cover = 0.4, .soft = 0.1});
  AddBlocks(w, {"ice blocks", "IceBlock", 6, 0.012, 1.2, 320, 0.36, 1.8, 0.3, 0.18, 0.6},
            {.above_water_m = {0.4, 1e4, 0.2}, .patches_m = 55, .cover = 0.3, .soft = 0.1});
}

void AddArcticStones(LayerWriter& w, Rng& rng) {
  AddBlocks(w,
            {"boulders", "Boulder", 6, rng.Uniform(0.006, 0.03), 1, 320, 0.4, 2.4, 0.4, 0.2, 0.6},
            {.above_water_m = {0.2, 1e4, 0.2}, .patches_m = 42, .cover = 0.35, .soft = 0.12});
  AddCover(w, {"stones", "Boulder", 6, 5, 80, 0.05, 0.42, 0.2, 0.12},
           {.above_water_m = {0.1, 1e4, 0.15}, .patches_m = 15, .cover = 0.3, .soft = 0.12},
           Matter::kBrokenRock);
  AddCover(w, {"broken ice", "IceBlock", 6, 6, 70, 0.05, 0.38, 0.2, 0.1},
           {.above_water_m = {0.02, 1.6, 0.3}, .patches_m = 9, .cover = 0.45, .soft = 0.15},
           Matter::kBrokenRock);
}

void WriteArctic(BiomeDraft& draft) {
  LayerWriter w(draft);
  Rng rng = w.Stream("arctic");
  w.AddGround({});
  // Where wind keeps the ground bare.
  w.AddGround({.above_water_m = {0.25, 1e4, 0.2},
               .patches_m = 20,
               .cover = rng.Uniform(0.05, 0.25),
               .soft = 0.08});
  w.AddGround({.above_water_m = {-99, 0.12, 0.25}});
  w.AddGround({.slope = {0.55, 99, 0.15}});
  AddFloes(w, rng);
  AddShoreIce(w);
  AddArcticStones(w, rng);
}

}  // namespace

const Biome kArctic = {
    .name = "arctic",
    .landform = "arctic",
    .weight = [](const v1::BiomeWeights& weights) { return weights.arctic(); },
    .ground = &ArcticGround,
    .write = &WriteArctic,
    .trace_times = 0.4,
    .wind = 0.3,
    .clarity = 1.6,
    .clear_water = {0.006f, 0.022f, 0.03f},
    .murky_water = {0.02f, 0.05f, 0.055f},
};

}  // namespace parallax
