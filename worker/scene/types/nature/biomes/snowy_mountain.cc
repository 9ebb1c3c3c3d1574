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
  w.Add({.name = "snags",
         .asset = "Snag",
         .shapes = 2,
         .each = true,
         .per_m2 = 0.0008,
         .spacing_m = 5,
         .reach_m = 160,
         .low = 0.7,
         .high = 1.2,
         .sink_m = 0.1,
         .claim_m = 0.4,
         .snow_m = 0.06,
         .mask = {.slope = kWalkable, .height_m = below_trees}});
}

// Plants that reach out of the snow, and what fell on it.
void AddSnowyPlants(LayerWriter& w, const MaskSpec::Range& below_trees) {
  w.Add({.name = "bushes",
         .asset = "DryBush",
         .shapes = 4,
         .each = true,
         .per_m2 = 0.02,
         .spacing_m = 1.4,
         .reach_m = 160,
         .low = 0.3,
         .high = 0.9,
         .sink_m = 0.05,
         .claim_m = 0.3,
         .snow_m = 0.03,
         .mask = {.slope = kFirmSnow,
                  .height_m = below_trees,
                  .patches_m = 25,
                  .cover = 0.35,
                  .soft = 0.1}});
  w.Add({.name = "tussocks",
         .asset = "Tussock",
         .shapes = 4,
         .per_m2 = 0.1,
         .spacing_m = 0.5,
         .reach_m = 70,
         .low = 0.4,
         .high = 0.9,
         .upright = 0.7,
         .sink_m = 0.12,
         .mask = {.slope = kFirmSnow, .patches_m = 12, .cover = 0.3, .soft = 0.12}});
  w.Add({.name = "twigs",
         .asset = "Twigs",
         .shapes = 4,
         .per_m2 = 0.7,
         .reach_m = 28,
         .low = 0.7,
         .high = 1.4,
         .upright = 0.05,
         .sink_m = 0,
         .near_parents_m = 6,
         .mask = {.slope = kWalkable}});
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
