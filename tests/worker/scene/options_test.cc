// Options of objects and materials: glass left out, the user's pictures, troublesome materials.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "common/image/io.h"
#include "tests/folder_test.h"
#include "worker/assets/asset.h"
#include "worker/materials/pictures/picture_folder.h"
#include "worker/materials/pictures/user_picture.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/choose_materials.h"
#include "worker/scene/floating/place_floating.h"
#include "worker/scene/glass_parts.h"
#include "worker/scene/scene_pictures.h"

namespace parallax {
namespace {

using testing::HasSubstr;

SceneInProgress OneObject(const std::string& asset_class, uint64_t seed) {
  SceneInProgress scene;
  scene.seed = SceneSeed{7};
  scene.recipe.set_type(v1::SCENE_TYPE_DENSE);
  scene.recipe.mutable_place()->mutable_open_sky();
  v1::SceneObject& object = *scene.recipe.add_objects();
  object.set_index(1);
  object.set_name(asset_class + "_1");
  object.set_asset_class(asset_class);
  object.set_seed(seed);
  object.set_role(v1::OBJECT_ROLE_FURNITURE);
  object.mutable_world_from_object()->set_qw(1);
  object.mutable_world_from_object()->set_scale(1);
  return scene;
}

v1::AssetConfig WithoutGlass() {
  v1::AssetConfig config;
  config.set_glass_parts(false);
  return config;
}

size_t TrianglesOf(const v1::Scene& recipe) {
  const absl::StatusOr<SceneGeometry> geometry = BuildSceneGeometry(recipe);
  EXPECT_TRUE(geometry.ok()) << geometry.status();
  const Mesh& mesh = *geometry->meshes.at(0).mesh;
  EXPECT_TRUE(ValidateMesh(mesh).ok()) << ValidateMesh(mesh);
  return mesh.triangles.size();
}

TEST(GlassParts, AreLeftOutOfObjectsThatHaveOtherParts) {
  SceneInProgress scene = OneObject("GlassPanelDoor", 3);
  const size_t whole = TrianglesOf(scene.recipe);
  ASSERT_TRUE(OmitGlassParts(WithoutGlass(), scene).ok());
  EXPECT_GT(scene.recipe.objects(0).omitted_slots_size(), 0);
  EXPECT_LT(TrianglesOf(scene.recipe), whole);
}

TEST(GlassParts, StayWhereAThingIsNothingElseOrTheConfigKeepsThem) {
  SceneInProgress glass = OneObject("Wineglass", 1);
  ASSERT_TRUE(OmitGlassParts(WithoutGlass(), glass).ok());
  EXPECT_EQ(glass.recipe.objects(0).omitted_slots_size(), 0);
  SceneInProgress door = OneObject("GlassPanelDoor", 3);
  ASSERT_TRUE(OmitGlassParts(v1::AssetConfig(), door).ok());
  EXPECT_EQ(door.recipe.objects(0).omitted_slots_size(), 0);
}

TEST(FloatingClasses, AreTheGroupsAndClassesAskedForLessTheExcludedOnes) {
  using testing::ElementsAre;
  v1::SceneConfig config;
  const size_t all = FloatingClasses(config)->size();
  EXPECT_GE(all, 75u);
  EXPECT_THAT(*FloatingClasses(config), testing::Not(testing::Contains("Cactus")));
  config.mutable_assets()->add_exclude("Chair");
  EXPECT_EQ(FloatingClasses(config)->size(), all - 1);
  EXPECT_THAT(*FloatingClasses(config), testing::Not(testing::Contains("Chair")));
  config.mutable_floating()->add_classes("bushes");
  config.mutable_floating()->add_classes("Cactus");
  config.mutable_floating()->add_classes("Bush");
  EXPECT_THAT(*FloatingClasses(config), ElementsAre("Bush", "Cactus"));
  config.mutable_floating()->add_classes("dead_wood");
  EXPECT_THAT(*FloatingClasses(config),
              ElementsAre("Bush", "Cactus", "Driftwood", "FallenTrunk", "Log", "Snag", "Stump"));
  config.mutable_floating()->add_classes("Unicorn");
  const absl::Status unknown = FloatingClasses(config).status();
  EXPECT_EQ(unknown.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(unknown.message()), HasSubstr("\"Unicorn\""));
}

// Classes that grow outdoors float only if they are named: studies that float all classes keep
// their draws.
TEST(FloatingClasses, HoldNatureOnlyWhereItIsNamed) {
  v1::SceneConfig config;
  config.mutable_floating()->add_classes("all");
  const auto all = FloatingClasses(config);
  ASSERT_TRUE(all.ok()) << all.status();
  for (const std::string& name : *all) {
    EXPECT_NE(FindAssetClass(name)->placement, Placement::kGround) << name;
  }
  config.mutable_floating()->clear_classes();
  config.mutable_floating()->add_classes("nature");
  const auto nature = FloatingClasses(config);
  ASSERT_TRUE(nature.ok()) << nature.status();
  EXPECT_GE(nature->size(), 20u);
  for (const std::string& name : *nature) {
    EXPECT_EQ(FindAssetClass(name)->placement, Placement::kGround) << name;
  }
}

class UserPictures : public FolderTest {
 protected:
  UserPictures() {
    SetPictureRoot("/");
    ImageRgb8 image(2, 2, 0);
    for (int y = 0; y < 2; ++y) image(0, y, 0) = image(1, y, 2) = 255;  // Red left, blue right.
    EXPECT_TRUE(WritePng(dir_ + "/red_blue.png", image).ok());
  }
  ~UserPictures() override { SetPictureRoot(""); }
};

TEST_F(UserPictures, ArePrintedUprightAndFadeToTheirMean) {
  const auto picture = MakeUserPicture(dir_ + "/red_blue.png", 1);
  ASSERT_TRUE(picture.ok()) << picture.status();
  SurfacePoint point;
  point.footprint_uv = 0.01f;
  point.uv = {0.1f, 0.5f};
  const Vec3f left = (*picture)->Evaluate(point).base_color;
  point.uv = {0.9f, 0.5f};
  const Vec3f right = (*picture)->Evaluate(point).base_color;
  EXPECT_GT(left.x(), 0.5f);
  EXPECT_LT(left.z(), 0.1f);
  EXPECT_GT(right.z(), 0.5f);
  point.footprint_uv = 4;
  const Vec3f far = (*picture)->Evaluate(point).base_color;
  EXPECT_NEAR(far.x(), far.z(), 1e-4f);
}

TEST_F(UserPictures, ReplaceProceduralPrints) {
  SceneInProgress scene = OneObject("WallArt", 5);
  v1::MaterialConfig config;
  config.set_mode(v1::MaterialConfig::MODE_ALL);
  config.set_picture_dir(dir_);
  ASSERT_TRUE(ChooseMaterials(config, nullptr, scene).ok());
  int printed = 0;
  for (const v1::SceneMaterial& material : scene.recipe.materials()) {
    printed += material.picture_file() == "red_blue.png";
  }
  EXPECT_EQ(printed, 1);
  ASSERT_TRUE(LocatePictures(dir_, scene.recipe).ok());
  EXPECT_TRUE(BuildSceneGeometry(scene.recipe).ok());
}

// A recipe names pictures by their content: it is the same wherever the folder lies.
TEST_F(UserPictures, CountByTheirContentAndNotByTheirPlace) {
  const auto recipe = [](const std::string& dir) {
    SceneInProgress scene = OneObject("WallArt", 5);
    v1::MaterialConfig config;
    config.set_mode(v1::MaterialConfig::MODE_ALL);
    config.set_picture_dir(dir);
    EXPECT_TRUE(ChooseMaterials(config, nullptr, scene).ok());
    return scene.recipe.SerializeAsString();
  };
  const std::string before = recipe(dir_), hash = ContentHashOf(*ReadPictureFolder(dir_));
  const std::string moved = dir_ + "_moved";
  std::filesystem::remove_all(moved);
  std::filesystem::rename(dir_, moved);
  EXPECT_EQ(recipe(moved), before);
  EXPECT_EQ(ContentHashOf(*ReadPictureFolder(moved)), hash);

  ASSERT_TRUE(WritePng(moved + "/red_blue.png", ImageRgb8(2, 2, 9)).ok());
  EXPECT_NE(recipe(moved), before);
  const std::string changed = ContentHashOf(*ReadPictureFolder(moved));
  EXPECT_NE(changed, hash);
  std::filesystem::rename(moved + "/red_blue.png", moved + "/blue_red.png");
  EXPECT_NE(ContentHashOf(*ReadPictureFolder(moved)), changed) << "another name";
  std::filesystem::remove_all(moved);
}

TEST_F(UserPictures, ThatAreNotTheStudysFailTheJobAndSaySo) {
  v1::MaterialConfig config;
  config.set_mode(v1::MaterialConfig::MODE_ALL);
  config.set_picture_dir(dir_);
  config.set_pictures_sha256(ContentHashOf(*ReadPictureFolder(dir_)));
  SceneInProgress scene = OneObject("WallArt", 5);
  ASSERT_TRUE(ChooseMaterials(config, nullptr, scene).ok());
  v1::Scene located = scene.recipe;
  ASSERT_TRUE(LocatePictures(dir_, located).ok());

  ASSERT_TRUE(WritePng(dir_ + "/red_blue.png", ImageRgb8(2, 2, 9)).ok());
  SceneInProgress again = OneObject("WallArt", 5);
  const absl::Status solve = ChooseMaterials(config, nullptr, again);
  EXPECT_EQ(solve.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(std::string(solve.message()), HasSubstr("not those that the study was submitted"));
  located = scene.recipe;
  const absl::Status render = LocatePictures(dir_, located);
  EXPECT_EQ(render.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(std::string(render.message()), HasSubstr("red_blue.png is not the one"));
  EXPECT_EQ(LocatePictures("", located).code(), absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(FindPicture(dir_, "../etc/passwd", "x").status().code(),
            absl::StatusCode::kInvalidArgument);
}

TEST_F(UserPictures, MustBeThere) {
  SceneInProgress scene = OneObject("WallArt", 5);
  v1::MaterialConfig config;
  config.set_picture_dir(dir_ + "/nowhere");
  const absl::Status status = ChooseMaterials(config, nullptr, scene);
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), HasSubstr("nowhere"));
}

TEST_F(UserPictures, AreReadBelowTheRootOnly) {
  const std::string inside = dir_ + "/inside", picture = dir_ + "/red_blue.png";
  std::filesystem::create_directories(inside + "/posters");
  std::filesystem::copy(picture, inside + "/posters/one.png");
  std::filesystem::create_symlink(dir_, inside + "/way_out");
  const auto code = [](const auto& result) { return result.status().code(); };
  SetPictureRoot("");
  EXPECT_EQ(code(BelowPictureRoot("posters")), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(code(MakeUserPicture(picture, 1)), absl::StatusCode::kFailedPrecondition);
  for (const std::string& root : {inside, inside + "/"}) {
    SetPictureRoot(root);
    const auto folder = BelowPictureRoot("posters");
    ASSERT_TRUE(folder.ok()) << folder.status();
    EXPECT_TRUE(MakeUserPicture(*folder + "/one.png", 1).ok());
    for (const std::string& outside : {dir_, std::string(".."), std::string("way_out")}) {
      EXPECT_EQ(code(BelowPictureRoot(outside)), absl::StatusCode::kFailedPrecondition) << outside;
    }
    EXPECT_EQ(code(MakeUserPicture(picture, 1)), absl::StatusCode::kFailedPrecondition);
  }
}

TEST(TroublesomeMaterials, ReplaceOthersOnlyWhenAskedFor) {
  const auto drawn = [](bool troublesome) {
    std::set<std::string> names;
    for (uint64_t seed = 1; seed <= 60; ++seed) {
      SceneInProgress scene = OneObject("Bowl", seed);
      scene.seed = SceneSeed{seed};
      v1::MaterialConfig config;
      config.set_mode(v1::MaterialConfig::MODE_METAL_GLASS);
      config.set_troublesome(troublesome);
      EXPECT_TRUE(ChooseMaterials(config, nullptr, scene).ok());
      for (const auto& material : scene.recipe.materials()) names.insert(material.material_class());
    }
    return names.contains("ClearGlass") || names.contains("Mirror") || names.contains("SolidGlass");
  };
  EXPECT_FALSE(drawn(false));
  EXPECT_TRUE(drawn(true));
}

}  // namespace
}  // namespace parallax
