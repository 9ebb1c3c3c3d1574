// The lands that there are (configs/biomes, and the user's own), and what a land's file writes into
// a recipe.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/base/rng.h"
#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// Heights of the site where the walk goes; masks refer to them.
// Quantiles in world metres.
struct SiteHeights {
  float low_m = 0, middle_m = 0, high_m = 0;  // 5 %, 50 %, 95 %.
  // The height below which this share of the relief lies, 0 to 1 between low and high.
  float At(float share) const { return low_m + share * (high_m - low_m); }
};

// The random numbers that a land draws, and the recipe that it writes, which has the landform.
struct BiomeDraft {
  const Rng& rng;            // The biome's own address.
  const std::string season;  // "spring", "summer", "autumn", "winter".
  double density = 1;        // Scales that of plants.
  SiteHeights heights;
  v1::Terrain& recipe;
};

// Writes ground rules, prototypes, layers and roof of a land, in the order of its file. Errors:
// those of ValueOfFormula; those of TerrainSpecOf where it has a roof.
absl::Status WriteRules(const v1::Biome& biome, BiomeDraft& draft);

// Returns the classes of the ground's materials, one for each rule that WriteRules has written into
// `recipe`, in their order; the last is bare rock.
std::vector<std::string> GroundMaterials(const v1::Biome& biome, const v1::Terrain& recipe);

struct WeightedBiome {
  const v1::Biome* biome;
  double weight;  // 0 or more.
};
// Returns the built-in lands in order of name, then the config's own, which must outlive it.
std::vector<WeightedBiome> BiomesOf(const v1::NatureConfig& nature);
// Returns one of them by its name; nullptr when no such name exists.
const v1::Biome* FindBiome(const v1::NatureConfig& nature, std::string_view name);

}  // namespace parallax
