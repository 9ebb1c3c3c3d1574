#include "worker/scene/types/nature/rules/biomes.h"

#include <algorithm>

#include "common/config/files/land_files.h"

namespace parallax {

std::vector<WeightedBiome> BiomesOf(const v1::NatureConfig& nature) {
  std::vector<WeightedBiome> biomes;
  const v1::BiomeWeights& weights = nature.biomes();
  for (const v1::Biome& biome : BuiltinBiomes()) {
    const auto* field = weights.GetDescriptor()->FindFieldByName(biome.name());
    const double weight = field == nullptr ? 0 : weights.GetReflection()->GetDouble(weights, field);
    biomes.push_back({&biome, std::max(0.0, weight)});
  }
  for (const v1::OwnBiome& own : nature.own_biomes()) {
    biomes.push_back({&own.biome(), std::max(0.0, own.weight())});
  }
  return biomes;
}

const v1::Biome* FindBiome(const v1::NatureConfig& nature, std::string_view name) {
  for (const WeightedBiome& row : BiomesOf(nature)) {
    if (row.biome->name() == name) return row.biome;
  }
  return nullptr;
}

}  // namespace parallax
