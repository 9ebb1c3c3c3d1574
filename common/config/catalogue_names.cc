#include "common/config/catalogue_names.h"

#include <algorithm>

namespace parallax {
namespace {

// A new class of worker/assets or worker/materials needs its name here; a test of the worker
// compares both lists and names what differs.
constexpr std::string_view kAssetClasses[] = {"ArmChair",
                                              "Balloon",
                                              "BarChair",
                                              "BasketBase",
                                              "BathroomSink",
                                              "Bathtub",
                                              "Bed",
                                              "BedFrame",
                                              "BeverageFridge",
                                              "Blanket",
                                              "Book",
                                              "BookColumn",
                                              "BookStack",
                                              "Bottle",
                                              "Boulder",
                                              "Bowl",
                                              "BroadleafTree",
                                              "Bush",
                                              "Cactus",
                                              "Can",
                                              "CeilingClassicLamp",
                                              "CellShelf",
                                              "Chair",
                                              "Chopsticks",
                                              "CoffeeTable",
                                              "Cones",
                                              "Conifer",
                                              "Cup",
                                              "CurvedStaircase",
                                              "DeskLamp",
                                              "Dishwasher",
                                              "DryBush",
                                              "FallenTrunk",
                                              "FernPlant",
                                              "FloorLamp",
                                              "FlowerBush",
                                              "FlowerPlant",
                                              "FoodBag",
                                              "FoodBox",
                                              "Fork",
                                              "FruitContainer",
                                              "GlassPanelDoor",
                                              "GrassClump",
                                              "GrassTuft",
                                              "Hardware",
                                              "Jar",
                                              "KitchenCabinet",
                                              "KitchenIsland",
                                              "KitchenSpace",
                                              "Knife",
                                              "Lamp",
                                              "LargePlantContainer",
                                              "LargeShelf",
                                              "LeafLitter",
                                              "Lid",
                                              "LiteDoor",
                                              "Log",
                                              "LouverDoor",
                                              "Mattress",
                                              "Microwave",
                                              "Mirror",
                                              "Monitor",
                                              "Mushrooms",
                                              "NatureShelfTrinkets",
                                              "NeedlePatch",
                                              "OfficeChair",
                                              "Oven",
                                              "Pallet",
                                              "Pan",
                                              "PanelDoor",
                                              "Pants",
                                              "Pebbles",
                                              "Pillow",
                                              "PlantContainer",
                                              "Plate",
                                              "Pot",
                                              "Rack",
                                              "Reed",
                                              "RockPile",
                                              "Rug",
                                              "Shirt",
                                              "Shrub",
                                              "SideTable",
                                              "SimpleBookcase",
                                              "SimpleDesk",
                                              "SingleCabinet",
                                              "Sink",
                                              "Slab",
                                              "Snag",
                                              "Sofa",
                                              "SpiralStaircase",
                                              "Spoon",
                                              "StraightStaircase",
                                              "Stump",
                                              "Succulent",
                                              "TV",
                                              "TVStand",
                                              "TableCocktail",
                                              "TableDining",
                                              "Tap",
                                              "Towel",
                                              "TriangleShelf",
                                              "Tussock",
                                              "Twigs",
                                              "UShapedStaircase",
                                              "Urchin",
                                              "Vase",
                                              "WallArt",
                                              "Window",
                                              "Wineglass"};

constexpr std::string_view kAssetGroups[] = {"all",    "bushes", "chairs", "dead_wood",
                                             "herbs",  "litter", "nature", "shelves",
                                             "shrubs", "stones", "trees"};

// Families in lower case, and the classes that any object may have.
constexpr std::string_view kObjectMaterials[] = {"AntiqueMirror",
                                                 "ApplianceEnamel",
                                                 "AshWood",
                                                 "Bark",
                                                 "BasketWeaveFabric",
                                                 "BeechWood",
                                                 "BoucleFabric",
                                                 "BreadCrust",
                                                 "BrushedMetal",
                                                 "Cardboard",
                                                 "Carpet",
                                                 "CastIron",
                                                 "CherryWood",
                                                 "CitrusPeel",
                                                 "ClearGlass",
                                                 "Concrete",
                                                 "DamaskWallpaper",
                                                 "Denim",
                                                 "DottedWallpaper",
                                                 "EbonyWood",
                                                 "FoamRubber",
                                                 "FrostedGlass",
                                                 "FruitSkin",
                                                 "GalvanizedMetal",
                                                 "GeometricWallpaper",
                                                 "GlazedCeramic",
                                                 "GlossyPlastic",
                                                 "Granite",
                                                 "Grass",
                                                 "Gravel",
                                                 "HammeredMetal",
                                                 "HousingPlastic",
                                                 "KnitFabric",
                                                 "LacquerPaint",
                                                 "Leaf",
                                                 "Leather",
                                                 "LinenFabric",
                                                 "MahoganyWood",
                                                 "Marble",
                                                 "MarbledPlastic",
                                                 "MattePlastic",
                                                 "Mirror",
                                                 "MosaicTiles",
                                                 "OakWood",
                                                 "PaintedMetal",
                                                 "Paper",
                                                 "PineWood",
                                                 "Plaster",
                                                 "PolishedMetal",
                                                 "QuiltedLeather",
                                                 "Rock",
                                                 "RoughPlastic",
                                                 "RugPattern",
                                                 "RustedMetal",
                                                 "Sand",
                                                 "Sandstone",
                                                 "SanitaryCeramic",
                                                 "ShagCarpet",
                                                 "Skin",
                                                 "Slate",
                                                 "Soil",
                                                 "SolidGlass",
                                                 "SpeckledCeramic",
                                                 "SprigWallpaper",
                                                 "StripedFabric",
                                                 "StripedWallpaper",
                                                 "Suede",
                                                 "TartanFabric",
                                                 "Terracotta",
                                                 "Terrazzo",
                                                 "TerryCloth",
                                                 "TintedGlass",
                                                 "TwillFabric",
                                                 "VelvetFabric",
                                                 "WallPaint",
                                                 "WalnutWood",
                                                 "Wax",
                                                 "WovenFabric",
                                                 "bark",
                                                 "carpet",
                                                 "ceramic",
                                                 "concrete",
                                                 "fabric",
                                                 "food",
                                                 "glass",
                                                 "leaf",
                                                 "leather",
                                                 "metal",
                                                 "mirror",
                                                 "paint",
                                                 "paper",
                                                 "plastic",
                                                 "rock",
                                                 "sand",
                                                 "skin",
                                                 "soil",
                                                 "stone",
                                                 "terrazzo",
                                                 "wallpaper",
                                                 "wood"};

constexpr std::string_view kBenchmarks[] = {
    "booster-Q",           "drivingstereo",    "eth3d",
    "kitti2012",           "kitti2015",        "middlebury2014-F",
    "middlebury2014-H",    "middlebury2014-Q", "middlebury2014-heldout",
    "middlebury2014-sets", "middlebury2021",   "shipped"};
constexpr std::string_view kBaselines[] = {"sgbm"};

template <size_t kCount>
std::vector<std::string> ListOf(const std::string_view (&names)[kCount]) {
  return {std::begin(names), std::end(names)};
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

const std::vector<std::string>& BenchmarkNames() {
  static const auto& names = *new std::vector<std::string>(ListOf(kBenchmarks));
  return names;
}

const std::vector<std::string>& BaselineNames() {
  static const auto& names = *new std::vector<std::string>(ListOf(kBaselines));
  return names;
}

}  // namespace parallax
