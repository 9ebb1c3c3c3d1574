// The names that studies are checked against are those of the catalogues.
#include "common/config/catalogue_names.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "common/config/config.h"
#include "worker/assets/asset.h"
#include "worker/assets/nature/species.h"
#include "worker/materials/kernel/material.h"
#include "worker/scene/floating/place_floating.h"
#include "worker/terrain/landforms.h"

namespace parallax {
namespace {

using ::testing::UnorderedElementsAreArray;

TEST(CatalogueNames, ListEveryAssetClass) {
  std::vector<std::string> classes;
  for (const AssetClass& c : AssetCatalogue()) classes.push_back(c.name);
  EXPECT_THAT(AssetClassNames(), UnorderedElementsAreArray(classes));
}

TEST(CatalogueNames, ListEveryMaterialAndFamilyThatAnyObjectCanHave) {
  std::set<std::string> names;
  for (const MaterialClass& material : MaterialCatalogue()) {
    if (!material.tags.any_object) continue;
    names.insert(material.name);
    names.insert(material.family);
  }
  EXPECT_THAT(ObjectMaterialNames(), UnorderedElementsAreArray(names));
}

TEST(CatalogueNames, ListLandformsTreesAndMaterialsOfTheGround) {
  const auto& landforms = v1::Biome::descriptor()
                              ->FindFieldByName("landform")
                              ->options()
                              .GetExtension(v1::rule)
                              .allowed();
  EXPECT_THAT(LandformNames(), UnorderedElementsAreArray(landforms.begin(), landforms.end()));
  std::vector<std::string> trees;
  for (const auto& row : BroadleafTable())
    trees.push_back("BroadleafTree/" + std::string(row.name));
  for (const auto& row : ConiferTable()) trees.push_back("Conifer/" + std::string(row.name));
  EXPECT_THAT(TreeNames(), UnorderedElementsAreArray(trees));
  for (const std::string& name : GroundMaterialNames()) {
    EXPECT_NE(FindMaterialClass(name), nullptr) << name;
  }
}

TEST(CatalogueNames, OfClassesAndGroupsCanFloat) {
  for (const std::vector<std::string>& names : {AssetClassNames(), AssetGroupNames()}) {
    for (const std::string& name : names) {
      v1::SceneConfig config = DefaultSceneConfig();
      config.mutable_floating()->add_classes(name);
      const auto classes = FloatingClasses(config);
      EXPECT_TRUE(classes.ok()) << name << ": " << classes.status();
    }
  }
}

}  // namespace
}  // namespace parallax
