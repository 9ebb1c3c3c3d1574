#include "worker/scene/types/nature/rules/biomes.h"

namespace parallax {

const std::vector<const Biome*>& Biomes() {
  static const std::vector<const Biome*>& biomes = *new std::vector<const Biome*>{
      &kArctic, &kCanyon,   &kCave,  &kCliff, &kCoast,        &kDesert,
      &kForest, &kMountain, &kPlain, &kRiver, &kSnowyMountain};
  return biomes;
}

const Biome* FindBiome(std::string_view name) {
  for (const Biome* biome : Biomes()) {
    if (biome->name == name) return biome;
  }
  return nullptr;
}

}  // namespace parallax
