// Registers plants, stones and litter. They are drawn only when a config names a class, `nature` or
// one of its groups: see README.md.
#include "worker/assets/asset_families.h"
#include "worker/assets/nature/ground_cover.h"
#include "worker/assets/nature/trees.h"

namespace parallax {

void RegisterNature(std::vector<AssetClass>& classes) {
  const auto add = [&](const char* name, const char* family, Asset (*sample)(Rng&),
                       const SizeRange& size) {
    classes.push_back({name, family, Placement::kGround, false, 0, sample, size});
  };
  add("Agave", "desert_plants", SampleAgave, SizeRange({0.35f, 0.35f, 0.15f}, {3.2f, 3.2f, 4.6f}));
  add("BarrelCactus", "desert_plants", SampleBarrelCactus,
      SizeRange({0.2f, 0.2f, 0.15f}, {2.4f, 2.4f, 1.4f}));
  add("ColumnCactus", "desert_plants", SampleColumnCactus,
      SizeRange({0.15f, 0.15f, 1.1f}, {3, 3, 6.2f}));
  add("PricklyPear", "desert_plants", SamplePricklyPear,
      SizeRange({0.15f, 0.15f, 0.25f}, {2.6f, 2.6f, 1.8f}));
  add("DripstoneColumn", "formations", SampleDripstoneColumn,
      SizeRange({0.6f, 0.6f, 4.5f}, {4.5f, 4.5f, 9}));
  add("RockArch", "formations", SampleRockArch, SizeRange({6, 1.5f, 3.5f}, {20, 10, 16}));
  add("RockPillar", "formations", SampleRockPillar, SizeRange({1, 1, 4.5f}, {12, 12, 16}));
  add("Stalagmites", "formations", SampleStalagmites,
      SizeRange({0.1f, 0.1f, 0.25f}, {3.2f, 3.2f, 1.7f}));
  classes.push_back({"Stalactites", "formations", Placement::kCeiling, false, 0, SampleStalactites,
                     SizeRange({0.15f, 0.15f, 0.3f}, {2.4f, 2.4f, 1.9f})});
  add("Boulder", "stones", SampleBoulder, SizeRange({0.3f, 0.25f, 0.2f}, {2.8f, 2.4f, 2.2f}));
  add("IceBlock", "stones", SampleIceBlock, SizeRange({0.5f, 0.35f, 0.2f}, {3.4f, 2.6f, 2.0f}));
  add("IceFloe", "stones", SampleIceFloe, SizeRange({0.9f, 0.9f, 0.15f}, {3.2f, 3.2f, 0.6f}));
  add("Pebbles", "stones", SamplePebbles, SizeRange({0.15f, 0.15f, 0.01f}, {0.8f, 0.8f, 0.12f}));
  add("RockPile", "stones", SampleRockPile, SizeRange({0.6f, 0.6f, 0.18f}, {3.6f, 3.6f, 1.8f}));
  add("SeaStack", "stones", SampleSeaStack, SizeRange({0.8f, 0.6f, 0.6f}, {3.6f, 3.0f, 4.6f}));
  add("Slab", "stones", SampleSlab, SizeRange({0.5f, 0.35f, 0.06f}, {3.4f, 2.6f, 0.8f}));
  add("Cones", "litter", SampleCones, SizeRange({0.05f, 0.05f, 0.02f}, {0.75f, 0.75f, 0.12f}));
  add("LeafLitter", "litter", SampleLeafLitter,
      SizeRange({0.35f, 0.35f, 0.02f}, {1.35f, 1.35f, 0.16f}));
  add("NeedlePatch", "litter", SampleNeedlePatch,
      SizeRange({0.25f, 0.25f, 0.01f}, {0.9f, 0.9f, 0.07f}));
  add("Shells", "litter", SampleShells, SizeRange({0.15f, 0.15f, 0.005f}, {1.2f, 1.2f, 0.12f}));
  add("Twigs", "litter", SampleTwigs, SizeRange({0.3f, 0.3f, 0.01f}, {1.8f, 1.8f, 0.25f}));
  add("Wrack", "litter", SampleWrack, SizeRange({0.4f, 0.25f, 0.01f}, {1.9f, 1.4f, 0.3f}));
  add("FernPlant", "herbs", SampleFern, SizeRange({0.35f, 0.35f, 0.15f}, {1.9f, 1.9f, 1.1f}));
  add("FlowerPlant", "herbs", SampleFlowerPlant,
      SizeRange({0.1f, 0.1f, 0.1f}, {0.9f, 0.9f, 0.55f}));
  add("GrassClump", "herbs", SampleGrassClump, SizeRange({0.6f, 0.6f, 0.1f}, {1.7f, 1.7f, 0.65f}));
  add("GrassTuft", "herbs", SampleGrassTuft, SizeRange({0.08f, 0.08f, 0.07f}, {0.9f, 0.9f, 0.65f}));
  add("Mushrooms", "herbs", SampleMushrooms,
      SizeRange({0.03f, 0.03f, 0.03f}, {0.55f, 0.55f, 0.2f}));
  add("Reed", "herbs", SampleReed, SizeRange({0.3f, 0.3f, 0.9f}, {2.2f, 2.2f, 2.6f}));
  add("Succulent", "herbs", SampleSucculent, SizeRange({0.12f, 0.12f, 0.05f}, {2.2f, 2.2f, 0.6f}));
  add("Tussock", "herbs", SampleTussock, SizeRange({0.4f, 0.4f, 0.2f}, {1.8f, 1.8f, 1.2f}));
  add("DryBush", "shrubs", SampleDryBush, SizeRange({0.4f, 0.4f, 0.4f}, {3.4f, 3.4f, 2.6f}));
  add("FlowerBush", "shrubs", SampleFlowerBush, SizeRange({0.4f, 0.4f, 0.4f}, {3.4f, 3.4f, 2.6f}));
  add("Shrub", "shrubs", SampleShrub, SizeRange({0.4f, 0.4f, 0.4f}, {3.4f, 3.4f, 2.6f}));
  add("BroadleafTree", "trees", SampleBroadleafTree, SizeRange({2, 2, 4}, {18, 18, 17}));
  add("Conifer", "trees", SampleConifer, SizeRange({2, 2, 7}, {11, 11, 15}));
  add("Palm", "trees", SamplePalm, SizeRange({2, 2, 3}, {8, 8, 12.5f}));
  add("Driftwood", "dead_wood", SampleDriftwood,
      SizeRange({0.7f, 0.06f, 0.06f}, {4.6f, 2.6f, 2.4f}));
  add("FallenTrunk", "dead_wood", SampleFallenTrunk, SizeRange({2.8f, 0.2f, 0.2f}, {9, 3, 2.5f}));
  add("Log", "dead_wood", SampleLog, SizeRange({0.85f, 0.15f, 0.15f}, {3.6f, 1.0f, 1.0f}));
  add("Snag", "dead_wood", SampleSnag, SizeRange({0.3f, 0.3f, 2.2f}, {3.5f, 3.5f, 8.5f}));
  add("Stump", "dead_wood", SampleStump, SizeRange({0.35f, 0.35f, 0.2f}, {2.1f, 2.1f, 1.0f}));
}

}  // namespace parallax
