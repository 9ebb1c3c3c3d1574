// The biomes: one row each of a table. A row names the landform and the ground's materials of a
// biome, and writes its prototypes and layers.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/rng.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/terrain/terrain.h"

namespace parallax {

// Heights of the site where the walk goes; masks refer to them.
// Quantiles in world metres.
struct SiteHeights {
  float low_m = 0, middle_m = 0, high_m = 0;  // 5 %, 50 %, 95 %.
  // The height below which this share of the relief lies, 0 to 1 between low and high.
  float At(float share) const { return low_m + share * (high_m - low_m); }
};

// The random numbers that a row draws, and the recipe that it writes.
struct BiomeDraft {
  const Rng& rng;            // The biome's own address.
  const std::string season;  // "spring", "summer", "autumn", "winter".
  double density = 1;        // Scales that of plants.
  SiteHeights heights;
  v1::Terrain& recipe;
};

// One row of the table.
struct Biome {
  std::string_view name;
  std::string_view landform;
  double (*weight)(const v1::BiomeWeights& weights);
  // Classes of the ground's materials, one for each rule that `write` adds, in their order; the
  // last is bare rock. `season` as in BiomeDraft.
  std::vector<std::string> (*ground)(const std::string& season);
  void (*write)(BiomeDraft& draft);
  // SceneCosts::trace_times of its scenes: what grass and leaves cost.
  double trace_times = 1;
  // The water: its wind and clarity over the config's, and the linear colour that clear and murky
  // water scatters back.
  double wind = 1, clarity = 1;
  std::array<float, 3> clear_water = {0.006f, 0.026f, 0.034f};
  std::array<float, 3> murky_water = {0.05f, 0.085f, 0.07f};
};

// One file each in biomes/.
extern const Biome kArctic, kCanyon, kCave, kCliff, kCoast, kDesert, kForest, kMountain, kPlain,
    kRiver, kSnowyMountain;

// In order of name.
const std::vector<const Biome*>& Biomes();
// nullptr when no such name exists.
const Biome* FindBiome(std::string_view name);

}  // namespace parallax
