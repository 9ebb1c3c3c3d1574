#include "common/config/catalogue_names.h"

#include <iterator>
#include <sstream>

namespace parallax {
namespace {

// A new class of worker/assets or worker/materials needs its name here; a test of the worker
// compares both lists and names what differs.
constexpr char kAssetClasses[] = R"(
Agave ArmChair Balloon BarChair BarrelCactus BasketBase BathroomSink Bathtub Bed BedFrame
BeverageFridge Blanket Book BookColumn BookStack Bottle Boulder Bowl BroadleafTree Bush Cactus Can
CeilingClassicLamp CellShelf Chair Chopsticks CoffeeTable ColumnCactus Cones Conifer Cup
CurvedStaircase DeskLamp Dishwasher Driftwood DripstoneColumn DryBush FallenTrunk FernPlant
FloorLamp FlowerBush FlowerPlant FoodBag FoodBox Fork FruitContainer GlassPanelDoor GrassClump
GrassTuft Hardware IceBlock IceFloe Jar KitchenCabinet KitchenIsland KitchenSpace Knife Lamp
LargePlantContainer LargeShelf LeafLitter Lid LiteDoor Log LouverDoor Mattress Microwave Mirror
Monitor Mushrooms NatureShelfTrinkets NeedlePatch OfficeChair Oven Pallet Palm Pan PanelDoor Pants
Pebbles Pillow PlantContainer Plate Pot PricklyPear Rack Reed RockArch RockPile RockPillar Rug
SeaStack Shells Shirt Shrub SideTable SimpleBookcase SimpleDesk SingleCabinet Sink Slab Snag Sofa
SpiralStaircase Spoon Stalactites Stalagmites StraightStaircase Stump Succulent TV TVStand
TableCocktail TableDining Tap Towel TriangleShelf Tussock Twigs UShapedStaircase Urchin Vase WallArt
Window Wineglass Wrack
)";

constexpr char kAssetGroups[] = R"(
all bushes chairs dead_wood desert_plants formations herbs litter nature shelves shrubs stones trees
)";

constexpr char kRoomKinds[] = R"(
bathroom bedroom closet dining_room hallway kitchen living_room office
)";

// Families in lower case, and the classes that any object may have.
constexpr char kObjectMaterials[] = R"(
AntiqueMirror ApplianceEnamel AshWood Bark BasketWeaveFabric BeechWood BoucleFabric BreadCrust
BrushedMetal Cardboard Carpet CastIron CherryWood CitrusPeel ClearGlass Concrete DamaskWallpaper
Denim DottedWallpaper EbonyWood FoamRubber FrostedGlass FruitSkin GalvanizedMetal GeometricWallpaper
GlazedCeramic GlossyPlastic Granite Grass Gravel HammeredMetal HousingPlastic KnitFabric
LacquerPaint Leaf Leather LinenFabric MahoganyWood Marble MarbledPlastic MattePlastic Mirror
MosaicTiles OakWood PaintedMetal Paper PineWood Plaster PolishedMetal QuiltedLeather Rock
RoughPlastic RugPattern RustedMetal Sand Sandstone SanitaryCeramic ShagCarpet Skin Slate Soil
SolidGlass SpeckledCeramic SprigWallpaper StripedFabric StripedWallpaper Suede TartanFabric
Terracotta Terrazzo TerryCloth TintedGlass TwillFabric VelvetFabric WallPaint WalnutWood Wax
WovenFabric bark carpet ceramic concrete fabric food glass leaf leather metal mirror paint paper
plastic rock sand skin soil stone terrazzo wallpaper wood
)";

constexpr char kGroundMaterials[] = R"(
CaveRock DesertSand ForestFloor Granite Grass Gravel GreyStrata Moss MossyRock PackedSnow RedStrata
Rock Sand Sandstone SeaIce Slate Snow Soil
)";

constexpr char kTrees[] = R"(
BroadleafTree/acacia BroadleafTree/birch BroadleafTree/maple BroadleafTree/oak BroadleafTree/willow
Conifer/larch Conifer/pine Conifer/spruce
)";

constexpr char kBenchmarks[] = R"(
booster-Q drivingstereo eth3d kitti2012 kitti2015 middlebury2014-F middlebury2014-H middlebury2014-Q
middlebury2014-heldout middlebury2014-sets middlebury2021 shipped
)";

std::vector<std::string> ListOf(const char* names) {
  std::istringstream words(names);
  return {std::istream_iterator<std::string>(words), {}};
}

}  // namespace

const std::vector<std::string>& AssetClassNames() {
  static const auto& names = *new std::vector<std::string>(ListOf(kAssetClasses));
  return names;
}

const std::vector<std::string>& AssetGroupNames() {
  static const auto& names = *new std::vector<std::string>(ListOf(kAssetGroups));
  return names;
}

const std::vector<std::string>& ObjectMaterialNames() {
  static const auto& names = *new std::vector<std::string>(ListOf(kObjectMaterials));
  return names;
}

const std::vector<std::string>& GroundMaterialNames() {
  static const auto& names = *new std::vector<std::string>(ListOf(kGroundMaterials));
  return names;
}

const std::vector<std::string>& TreeNames() {
  static const auto& names = *new std::vector<std::string>(ListOf(kTrees));
  return names;
}

const std::vector<std::string>& RoomKindNames() {
  static const auto& names = *new std::vector<std::string>(ListOf(kRoomKinds));
  return names;
}

const std::vector<std::string>& BenchmarkNames() {
  static const auto& names = *new std::vector<std::string>(ListOf(kBenchmarks));
  return names;
}

const std::vector<std::string>& BaselineNames() {
  static const auto& names = *new std::vector<std::string>(ListOf("sgbm"));
  return names;
}

}  // namespace parallax
