// The whole catalogue, fifty seeds of each class: what must hold for every object.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <sstream>

#include "tests/worker/assets/solid_checks.h"
#include "worker/assets/asset.h"
#include "worker/assets/detail.h"
#include "worker/materials/kernel/material.h"

namespace parallax {
namespace {

constexpr uint64_t kPropertySeeds = 50;
constexpr int kLines = 4;  // An object.

std::vector<std::string> ClassNames() {
  std::vector<std::string> names;
  for (const AssetClass& c : AssetCatalogue()) names.push_back(c.name);
  return names;
}

class FiftySeeds : public testing::TestWithParam<std::string> {};

INSTANTIATE_TEST_SUITE_P(Catalogue, FiftySeeds, testing::ValuesIn(ClassNames()),
                         [](const auto& info) { return info.param; });

void ExpectSlotsWithMaterials(const Mesh& mesh) {
  std::set<std::string> names;
  for (const MaterialSlot& slot : mesh.slots) {
    EXPECT_TRUE(names.insert(slot.name).second) << "slot " << slot.name << " occurs twice";
    EXPECT_FALSE(slot.families.empty()) << slot.name;
    for (const std::string& family : slot.families) {
      EXPECT_FALSE(MaterialsOfFamily(family).empty()) << slot.name << ": " << family;
    }
  }
}

void ExpectSize(const Mesh& mesh, const SizeRange& range) {
  const Vec3f size = mesh.Bounds().sizes();
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_GE(size[axis], range.least_m[axis]) << "axis " << axis;
    EXPECT_LE(size[axis], range.most_m[axis]) << "axis " << axis;
  }
}

// Triangles at default detail. A made bed, a sofa with cushions and a whole kitchen are many
// things.
size_t Budget(const AssetClass& c) {
  if (c.family == "plants") return 100'000;
  if (c.family == "trees") return 150'000;
  const std::set<std::string> large{"Bed", "KitchenSpace", "NatureShelfTrinkets", "Sofa"};
  return large.contains(c.name) ? 60'000 : 40'000;
}

TEST_P(FiftySeeds, AreSoundSolidsOfRealSizeAllDifferent) {
  const AssetClass& asset_class = *FindAssetClass(GetParam());
  ASSERT_GT(asset_class.size.least_m.minCoeff(), 0) << "no size where it is registered";
  std::set<size_t> shapes, outlines;
  for (uint64_t seed = 1; seed <= kPropertySeeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const absl::StatusOr<Asset> asset = MakeAsset(GetParam(), seed);
    ASSERT_TRUE(asset.ok()) << asset.status();
    const Mesh& mesh = asset->mesh;
    ASSERT_TRUE(ValidateMesh(mesh).ok()) << ValidateMesh(mesh);
    const std::vector<uint32_t> weld = test::Weld(mesh);
    EXPECT_EQ(test::DegenerateTriangles(mesh, weld), 0);
    EXPECT_EQ(test::UnreferencedVertices(mesh), 0);
    EXPECT_EQ(test::UnusedSlots(mesh), 0);
    const Mesh solid = test::WithoutSheets(mesh);
    EXPECT_EQ(test::OpenEdges(solid, weld), 0);
    EXPECT_EQ(test::InsideOutParts(solid, weld), 0);
    if (!solid.triangles.empty()) {
      EXPECT_EQ(test::WrongLines(solid, kLines, seed), 0);
    }
    ExpectSlotsWithMaterials(mesh);
    ExpectSize(mesh, asset_class.size);
    EXPECT_LE(mesh.triangles.size(), Budget(asset_class));
    const std::string bytes = test::Bytes(mesh);
    if (seed % 10 == 0) {
      EXPECT_TRUE(bytes == test::Bytes(MakeAsset(GetParam(), seed)->mesh)) << "not the same again";
    }
    const size_t points = mesh.positions.size() * sizeof(Vec3f);
    EXPECT_TRUE(shapes.insert(std::hash<std::string>()(bytes.substr(0, points))).second)
        << "the points of another seed";
    outlines.insert(std::hash<test::Outline>()(test::OutlineOf(mesh, asset_class.size.most_m)));
  }
  EXPECT_GE(outlines.size(), kPropertySeeds - 2) << "different outlines";
}

// Coarser pieces make the same thing of fewer triangles.
TEST_P(FiftySeeds, AreClosedAndCheaperAtCoarserDetail) {
  for (uint64_t seed = 1; seed <= 2; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Mesh usual = MakeAsset(GetParam(), seed)->mesh;
    size_t before = usual.triangles.size();
    for (const float edge_m : {0.03f, 0.1f}) {
      const absl::StatusOr<Asset> asset = MakeAsset(GetParam(), seed, edge_m);
      ASSERT_TRUE(asset.ok()) << asset.status();
      const Mesh& mesh = asset->mesh;
      ASSERT_TRUE(ValidateMesh(mesh).ok()) << ValidateMesh(mesh);
      const std::vector<uint32_t> weld = test::Weld(mesh);
      EXPECT_EQ(test::OpenEdges(test::WithoutSheets(mesh), weld), 0) << edge_m;
      EXPECT_EQ(test::DegenerateTriangles(mesh, weld), 0) << edge_m;
      const Vec3f usual_size = usual.Bounds().sizes(), size = mesh.Bounds().sizes();
      EXPECT_LT((size - usual_size).norm(), 0.2f * usual_size.norm()) << edge_m;
      if (edge_m == 0.1f) {
        EXPECT_LE(mesh.triangles.size(), std::max<size_t>(before, 500));
      }
      before = mesh.triangles.size();
    }
  }
}

TEST(PaperClasses, AreAllInTheCatalogue) {
  std::istringstream names(R"(
ArmChair Balloon BarChair BasketBase BathroomSink Bathtub Bed BedFrame BeverageFridge Blanket Book
BookColumn BookStack Bottle Bowl Can CeilingClassicLamp CellShelf Chair Chopsticks Cup
CurvedStaircase DeskLamp Dishwasher FloorLamp FoodBag FoodBox Fork GlassPanelDoor Hardware Jar
KitchenCabinet KitchenIsland KitchenSpace Knife Lamp LargePlantContainer LargeShelf Lid LiteDoor
LouverDoor Mattress Microwave Monitor NatureShelfTrinkets OfficeChair Oven Pallet PanelDoor Pants
Pillow PlantContainer Plate Pot Rug Shirt SimpleBookcase SimpleDesk SingleCabinet Sink Sofa
SpiralStaircase Spoon StraightStaircase TV TVStand TableCocktail TableDining Tap Towel TriangleShelf
UShapedStaircase Vase WallArt Wineglass Window Bush
)");
  for (std::string name; names >> name;) {
    const AssetClass* found = FindAssetClass(name);
    ASSERT_NE(found, nullptr) << name;
    EXPECT_TRUE(found->on_by_default) << name;
  }
  for (const char* name : {"Cactus", "Urchin", "Rack"}) {
    ASSERT_NE(FindAssetClass(name), nullptr) << name;
    EXPECT_FALSE(FindAssetClass(name)->on_by_default) << name;
  }
}

}  // namespace
}  // namespace parallax
