// Registers plants, stones and litter. They are drawn only when a config names a class, `nature` or
// one of its groups: see README.md.
#include "worker/assets/families.h"
#include "worker/assets/nature/ground.h"
#include "worker/assets/nature/trees.h"

namespace parallax {

void RegisterNature(std::vector<AssetClass>& classes) {
  const auto add = [&](const char* name, const char* family, Asset (*sample)(Rng&)) {
    classes.push_back({name, family, Placement::kGround, false, 0, sample});
  };
  add("Agave", "desert_plants", SampleAgave);
  add("BarrelCactus", "desert_plants", SampleBarrelCactus);
  add("ColumnCactus", "desert_plants", SampleColumnCactus);
  add("PricklyPear", "desert_plants", SamplePricklyPear);
  add("DripstoneColumn", "formations", SampleDripstoneColumn);
  add("RockArch", "formations", SampleRockArch);
  add("RockPillar", "formations", SampleRockPillar);
  add("Stalagmites", "formations", SampleStalagmites);
  classes.push_back(
      {"Stalactites", "formations", Placement::kCeiling, false, 0, SampleStalactites});
  add("Boulder", "stones", SampleBoulder);
  add("IceBlock", "stones", SampleIceBlock);
  add("IceFloe", "stones", SampleIceFloe);
  add("Pebbles", "stones", SamplePebbles);
  add("RockPile", "stones", SampleRockPile);
  add("SeaStack", "stones", SampleSeaStack);
  add("Slab", "stones", SampleSlab);
  add("Cones", "litter", SampleCones);
  add("LeafLitter", "litter", SampleLeafLitter);
  add("NeedlePatch", "litter", SampleNeedlePatch);
  add("Shells", "litter", SampleShells);
  add("Twigs", "litter", SampleTwigs);
  add("Wrack", "litter", SampleWrack);
  add("FernPlant", "herbs", SampleFern);
  add("FlowerPlant", "herbs", SampleFlowerPlant);
  add("GrassClump", "herbs", SampleGrassClump);
  add("GrassTuft", "herbs", SampleGrassTuft);
  add("Mushrooms", "herbs", SampleMushrooms);
  add("Reed", "herbs", SampleReed);
  add("Succulent", "herbs", SampleSucculent);
  add("Tussock", "herbs", SampleTussock);
  add("DryBush", "shrubs", SampleDryBush);
  add("FlowerBush", "shrubs", SampleFlowerBush);
  add("Shrub", "shrubs", SampleShrub);
  add("BroadleafTree", "trees", SampleBroadleafTree);
  add("Conifer", "trees", SampleConifer);
  add("Palm", "trees", SamplePalm);
  add("Driftwood", "dead_wood", SampleDriftwood);
  add("FallenTrunk", "dead_wood", SampleFallenTrunk);
  add("Log", "dead_wood", SampleLog);
  add("Snag", "dead_wood", SampleSnag);
  add("Stump", "dead_wood", SampleStump);
}

}  // namespace parallax
