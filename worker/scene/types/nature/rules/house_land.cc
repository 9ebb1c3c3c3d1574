#include "worker/scene/types/nature/rules/house_land.h"

#include <algorithm>
#include <string>
#include <vector>

#include "common/config/files/land_files.h"
#include "worker/scene/types/nature/rules/biomes.h"
#include "worker/scene/types/nature/rules/recipe.h"
#include "worker/terrain/landforms.h"

namespace parallax {
namespace {

// Draws the land that people build in, by the weights that lands have for it: none with water, as a
// plot knows nothing of its level.
const v1::Biome& DrawBuildingLand(Rng rng) {
  std::vector<const v1::Biome*> lands;
  for (const v1::Biome& biome : BuiltinBiomes()) lands.push_back(&biome);
  // The most likely first, as when they were a list.
  std::stable_sort(lands.begin(), lands.end(), [](const v1::Biome* a, const v1::Biome* b) {
    return a->house_weight() > b->house_weight();
  });
  double sum = 0;
  for (const v1::Biome* biome : lands) sum += biome->house_weight();
  double left = rng.Uniform() * sum;
  for (const v1::Biome* biome : lands) {
    if (left < biome->house_weight()) return *biome;
    left -= biome->house_weight();
  }
  return *lands.front();
}

// Nobody walks here: a tenth of the erosion's work does.
void MakeCoarse(TerrainSpec& spec) {
  spec.region_samples = 193;
  spec.site_m = 768;
  spec.site_samples = 257;
  spec.rain.droplets /= 12;
  spec.water.reset();
}

// Small things are seen near windows only; trees end where hills take over.
void MakeSparse(v1::Terrain& land) {
  constexpr double kLitter_m = 24, kStones_m = 140, kTrees_m = 380, kLitterShare = 0.3;
  for (v1::ScatterLayer& layer : *land.mutable_layers()) {
    const bool single = layer.index_each();
    const double reach = !single ? kLitter_m : layer.crown_m() > 1 ? kTrees_m : kStones_m;
    layer.set_reach_m(std::min(layer.reach_m(), reach));
    if (!single) layer.set_per_m2(layer.per_m2() * kLitterShare);
  }
  for (v1::Prototype& prototype : *land.mutable_prototypes()) {
    prototype.set_shapes(std::min(prototype.shapes(), 2u));
  }
}

v1::Plot PlotFor(const Rng& root, const Eigen::AlignedBox2d& house, double level_m,
                 const Terrain& terrain) {
  v1::Plot plot;
  plot.set_low_x_m(house.min().x());
  plot.set_low_y_m(house.min().y());
  plot.set_high_x_m(house.max().x());
  plot.set_high_y_m(house.max().y());
  plot.set_level_m(level_m);
  plot.set_base_m(double{terrain.Height(house.center().cast<float>(), 1)});
  plot.set_blend_m(root.Child("blend").Uniform(18, 45));
  plot.set_clearing_m(root.Child("clearing").Uniform(2, 22));
  return plot;
}

}  // namespace

absl::StatusOr<v1::Terrain> DrawHouseLand(const Rng& root, const Eigen::AlignedBox2d& house,
                                          double level_m) {
  const v1::Biome& biome = DrawBuildingLand(root.Child("biome"));
  ASSIGN_OR_RETURN(TerrainSpec spec,
                   DrawLandform(biome.landform(), root.Child("land").Child(biome.name())));
  MakeCoarse(spec);
  v1::Terrain land;
  land.set_biome(biome.name());
  SetTerrainSpec(spec, land);
  ASSIGN_OR_RETURN(const auto terrain, TerrainOf(land));
  static const std::vector<std::string> kSeasons = {"spring", "summer", "autumn", "winter"};
  land.set_season(root.Child("season").Pick(kSeasons));
  const Rng rules = root.Child("rules").Child(biome.name());
  BiomeDraft draft{rules,
                   land.season(),
                   root.Child("density").Uniform(0.6, 1.2),
                   {Quantile(terrain->surface(), 0.05f), Quantile(terrain->surface(), 0.5f),
                    Quantile(terrain->surface(), 0.95f)},
                   land};
  RETURN_IF_ERROR(WriteRules(biome, draft));
  MakeSparse(land);
  *land.mutable_plot() = PlotFor(root, house, level_m, *terrain);
  RETURN_IF_ERROR(CheckRules(land));
  return land;
}

}  // namespace parallax
