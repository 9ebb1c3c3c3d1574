#include <array>

#include "worker/scene/types/nature/biomes/shared.h"

namespace parallax {
namespace {

std::vector<std::string> SnowyGround(const std::string&) { return {"Gravel", "Snow", "Rock"}; }

constexpr MaskSpec::Range kFirmSnow = {0, 0.75, 0.15};  // Slope.

// In the order of SnowyGround: gravel, snow, rock.
void AddSnowyGround(LayerWriter& w) {
  w.AddGround({});
  w.AddGround({.snow_m = {0.1, 1e4, 0.08}});
  w.AddGround({.slope = {0.62, 99, 0.16}, .snow_m = {-1, 0.06, 0.1}});
}

void AddSnowyTrees(LayerWriter& w, Rng& rng, const MaskSpec::Range& below_trees) {
  const std::array<TreeKind, 3> kinds = {{
      {"spruces", "Conifer/spruce", 2.0, 0.024, 2.4, 1500, 0.6, 1.35, 0.09},
      {"pines", "Conifer/pine", 2.1, 0.016, 2.6, 1500, 0.6, 1.3, 0.08},
      {"larches", "Conifer/larch", 2.0, 0.014, 2.6, 1500, 0.6, 1.3, 0.06},
  }};
  const TreeKind kind =
      kinds[rng.Bernoulli(0.6) ? 0 : static_cast<size_t>(rng.UniformInt(1, w.bare() ? 1 : 2))];
  AddTrees(w, kind,
           {.slope = kFirmSnow,
            .height_m = below_trees,
            .patches_m = rng.Uniform(60, 140),
            .cover = rng.Uniform(0.25, 0.65),
            .soft = 0.08});
  AddSaplings(
      w, kind,
      {.slope = kFirmSnow, .height_m = below_trees, .patches_m = 35, .cover = 0.4, .soft = 0.1});
  AddPlant(w, {"snags", "Snag", 2, 0.0008, 5, 160, 0.7, 1.2, 0.1, 0.4, 0, 1, 0.06},
           {.slope = kWalkable, .height_m = below_trees});
}

// Plants that reach out of the snow, and what fell on it.
void AddSnowyPlants(LayerWriter& w, const MaskSpec::Range& below_trees) {
  AddPlant(
      w, {"bushes", "DryBush", 4, 0.02, 1.4, 160, 0.3, 0.9, 0.05, 0.3, 0, 1, 0.03},
      {.slope = kFirmSnow, .height_m = below_trees, .patches_m = 25, .cover = 0.35, .soft = 0.1});
  AddCover(w, {"tussocks", "Tussock", 4, 0.1, 70, 0.4, 0.9, 0.7, 0.12, 0.5},
           {.slope = kFirmSnow, .patches_m = 12, .cover = 0.3, .soft = 0.12});
  AddCover(w, {"twigs", "Twigs", 4, 0.7, 28, 0.7, 1.4, 0.05, 0, 0, 6}, {.slope = kWalkable});
}

void WriteSnowyMountain(BiomeDraft& draft) {
  LayerWriter w(draft);
  Rng rng = w.Stream("snowy mountain");
  const double span = static_cast<double>(draft.heights.high_m - draft.heights.low_m);
  const double tree_line =
      static_cast<double>(draft.heights.At(static_cast<float>(rng.Uniform(0.35, 0.8))));
  const MaskSpec::Range below_trees = {-9000, tree_line, 0.12 * span};
  AddSnowyGround(w);
  AddSnowyTrees(w, rng, below_trees);
  AddRubble(w, rng.Uniform(0.5, 1.2), {}, 0.14);
  AddSnowyPlants(w, below_trees);
}

}  // namespace

const Biome kSnowyMountain = {
    .name = "snowy_mountain",
    .landform = "snowy mountains",
    .weight = [](const v1::BiomeWeights& weights) { return weights.snowy_mountain(); },
    .ground = &SnowyGround,
    .write = &WriteSnowyMountain,
    .trace_times = 0.6,
};

}  // namespace parallax
