// The user's meshes, texture sets and surroundings in scenes.
#include "worker/scene/own_content.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <set>

#include "common/base/system/file.h"
#include "common/config/config.h"
#include "common/image/io.h"
#include "common/math/proto.h"
#include "tests/folder_test.h"
#include "tests/worker/assets/own_files.h"
#include "worker/materials/pictures/environment_folder.h"
#include "worker/materials/pictures/user_picture.h"
#include "worker/scene/build_geometry.h"
#include "worker/scene/floating/floating_choice.h"
#include "worker/scene/own_furniture.h"
#include "worker/scene/solve_scene.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using test::GlbBox;
using ::testing::HasSubstr;

class OwnContentTest : public FolderTest {
 protected:
  OwnContentTest() {
    MakeContent("one");
    SetPictureRoot(dir_);
  }
  ~OwnContentTest() override { SetPictureRoot(""); }

  void MakeContent(const std::string& place) const {
    const std::string dir = dir_ + "/" + place;
    for (const char* folder : {"/meshes/lamps", "/meshes/Chair", "/textures", "/hdris"}) {
      fs::create_directories(dir + folder);
    }
    EXPECT_TRUE(WriteFile(dir + "/meshes/lamps/tall.glb", GlbBox(1, 3, 1)).ok());
    EXPECT_TRUE(WriteFile(dir + "/meshes/lamps/low.glb", GlbBox(1, 0.5, 1)).ok());
    EXPECT_TRUE(WriteFile(dir + "/meshes/Chair/seat.glb", GlbBox(80, 100, 80)).ok());
    EXPECT_TRUE(WritePng(dir + "/textures/red_albedo.png", ImageRgb8(4, 4, 99)).ok());
    EXPECT_TRUE(WriteExrHalfRgb(dir + "/hdris/grey.exr", ImageF3(8, 4, 1.0f)).ok());
  }

  static v1::SceneConfig ConfigOf(const std::string& place) {
    v1::SceneConfig config = DefaultSceneConfig();
    config.mutable_assets()->add_include(place + "/meshes");
    config.mutable_materials()->set_texture_dir(place + "/textures");
    config.mutable_lighting()->set_hdri_dir(place + "/hdris");
    return config;
  }
  static v1::SolveJob JobOf(const v1::SceneConfig& config, uint64_t seed = 3) {
    v1::SolveJob job;
    job.set_scene_seed(seed);
    *job.mutable_config() = config;
    job.mutable_config()->mutable_solver()->set_steps(12);
    job.mutable_config()->mutable_rigs()->set_count(2);
    job.mutable_config()->mutable_floating()->mutable_count()->set_constant(12);
    return job;
  }
  static v1::Scene SceneOf(const v1::SolveJob& job) {
    const auto result = Solve(job, CancelToken());
    EXPECT_TRUE(result.ok() && result->has_scene()) << result.status();
    return result->scene();
  }
};

TEST_F(OwnContentTest, ScenesAreMadeOfItAndCanBeBuilt) {
  const v1::Scene scene = SceneOf(JobOf(ConfigOf("one")));
  int floating = 0, own = 0, textures = 0, looks = 0;
  for (const v1::SceneObject& object : scene.objects()) {
    if (object.role() != v1::OBJECT_ROLE_FLOATING) continue;
    ++floating;
    own += IsOwnClass(object.asset_class()) ? 1 : 0;
  }
  for (const v1::SceneMaterial& material : scene.materials()) {
    textures += material.material_class() == "own:red" ? 1 : 0;
    looks += material.material_class() == "mesh:0" ? 1 : 0;
  }
  EXPECT_GT(own, 0);
  EXPECT_LT(own, floating);
  EXPECT_GT(textures, 0);
  EXPECT_GT(looks, 0);
  EXPECT_NE(scene.sky().environment(), 0u);
  const auto geometry = BuildSceneGeometry(scene);
  ASSERT_TRUE(geometry.ok()) << geometry.status();
}

// Recipes name content, not places: the same from another folder, and with a job that says where.
TEST_F(OwnContentTest, RecipesAreTheSameWhereverItLies) {
  const v1::Scene here = SceneOf(JobOf(ConfigOf("one")));
  MakeContent("two");
  fs::remove_all(dir_ + "/one");
  EXPECT_EQ(SceneOf(JobOf(ConfigOf("two"))).SerializeAsString(), here.SerializeAsString());
  v1::RenderJob job;
  *job.mutable_scene() = here;
  const absl::Status nowhere = LocateOwnContent(job);
  EXPECT_EQ(nowhere.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(nowhere.message()), HasSubstr("nobody says in which folder"));
  job.add_include("two/meshes");
  job.set_texture_dir("two/textures");
  job.set_hdri_dir("two/hdris");
  EXPECT_TRUE(LocateOwnContent(job).ok()) << LocateOwnContent(job);
  SetPictureRoot(dir_ + "/two");
  EXPECT_EQ(LocateOwnContent(job).code(), absl::StatusCode::kNotFound) << "below the root only";
}

TEST_F(OwnContentTest, WithoutItNothingIsDrawnOtherwise) {
  const v1::SceneConfig without = DefaultSceneConfig();
  v1::SceneConfig none = ConfigOf("one");
  none.mutable_assets()->set_include_p(0);
  none.mutable_materials()->set_texture_p(0);
  none.mutable_lighting()->set_hdri_p(0);
  EXPECT_EQ(SceneOf(JobOf(none)).SerializeAsString(), SceneOf(JobOf(without)).SerializeAsString());
}

TEST_F(OwnContentTest, OtherContentThanTheStudysFailsTheJob) {
  v1::SceneConfig config = ConfigOf("one");
  const auto meshes = ReadMeshFolders({dir_ + "/one/meshes"});
  config.mutable_assets()->set_include_sha256(meshes->sha256);
  EXPECT_TRUE(ReadOwnContent(config).ok()) << ReadOwnContent(config).status();
  ASSERT_TRUE(WriteFile(dir_ + "/one/meshes/lamps/tall.glb", GlbBox(1, 4, 1)).ok());
  EXPECT_EQ(ReadOwnContent(config).status().code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(std::string(ReadOwnContent(config).status().message()),
              HasSubstr("assets.include: its content is not that which the study was submitted"));
  config = ConfigOf("one");
  config.mutable_lighting()->set_hdris_sha256(std::string(64, 'a'));
  EXPECT_EQ(ReadOwnContent(config).status().code(), absl::StatusCode::kDataLoss);
  config = ConfigOf("one");
  config.mutable_materials()->set_textures_sha256(std::string(64, 'a'));
  EXPECT_EQ(ReadOwnContent(config).status().code(), absl::StatusCode::kDataLoss);
}

TEST_F(OwnContentTest, FloatingClassesAreDrawnInProportionToTheirWeights) {
  v1::SceneConfig config = ConfigOf("one");
  config.mutable_floating()->add_classes("chairs");
  config.mutable_floating()->add_classes("own:lamps");
  config.mutable_floating()->add_classes("own:Chair");
  config.mutable_assets()->set_include_p(0.25);
  const auto weigh = [&](const char* name, double weight) {
    v1::ClassWeight& entry = *config.mutable_assets()->add_weights();
    entry.set_class_(name);
    entry.set_weight(weight);
  };
  weigh("own:lamps", 3);
  weigh("chairs", 2);
  weigh("BarChair", 0);  // After its group.
  const auto own = ReadOwnContent(config);
  ASSERT_TRUE(own.ok()) << own.status();
  const auto choice = FloatingChoice::Of(config, *own);
  ASSERT_TRUE(choice.ok()) << choice.status();
  std::map<std::string, int> counts;
  std::set<uint64_t> lamps;
  const Rng root(SceneSeed{1}, "weights");
  constexpr int kDraws = 4000;
  for (int i = 0; i < kDraws; ++i) {
    const auto model = choice->Draw(root.Child("object", static_cast<uint64_t>(i)));
    ++counts[model.asset_class];
    if (model.asset_class == "own:lamps") lamps.insert(model.seed);
  }
  EXPECT_NEAR(counts["own:lamps"], kDraws * 0.25 * 0.75, 110);
  EXPECT_NEAR(counts["own:Chair"], kDraws * 0.25 * 0.25, 65);
  EXPECT_NEAR(counts["ArmChair"], kDraws * 0.75 / 3, 120);
  EXPECT_EQ(counts["BarChair"], 0);
  EXPECT_EQ(lamps.size(), 2u) << "both files";

  config.mutable_floating()->clear_classes();
  config.mutable_floating()->add_classes("own");
  const auto only = FloatingChoice::Of(config, *own);
  ASSERT_TRUE(only.ok()) << only.status();
  EXPECT_TRUE(IsOwnClass(only->Draw(root.Child("x")).asset_class));
  config.mutable_floating()->set_classes(0, "own:cars");
  EXPECT_THAT(std::string(FloatingChoice::Of(config, *own).status().message()),
              HasSubstr("assets.include has no mesh of \"own:cars\""));
  config.mutable_floating()->set_classes(0, "own:lamps");
  weigh("own", 0);
  EXPECT_THAT(std::string(FloatingChoice::Of(config, *own).status().message()),
              HasSubstr("every class that may float weighs 0"));
}

TEST_F(OwnContentTest, FurnitureIsReplacedWithinItsBox) {
  SceneInProgress scene;
  scene.seed = SceneSeed{7};
  const auto add = [&](uint32_t index, const std::string& asset_class, uint32_t parent) {
    v1::SceneObject& object = *scene.recipe.add_objects();
    object.set_index(index);
    object.set_name(asset_class + "_" + std::to_string(index));
    object.set_asset_class(asset_class);
    object.set_seed(index);
    object.set_role(v1::OBJECT_ROLE_FURNITURE);
    object.set_parent_index(parent);
    Pose pose;
    pose.translation = {2.0 * index, 1, 0.5};
    pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(0.3 * index, Vec3d::UnitZ()));
    *object.mutable_world_from_object() = ToProto(pose);
  };
  add(1, "Chair", 0);
  add(2, "Chair", 0);
  add(3, "Book", 2);  // Something stands on the second chair.
  const v1::Scene before = scene.recipe;
  v1::SceneConfig config = ConfigOf("one");
  config.mutable_assets()->set_include_p(1);
  scene.own = *ReadOwnContent(config);
  ASSERT_TRUE(PutOwnFurniture(config.assets(), scene).ok());
  EXPECT_EQ(scene.recipe.objects(1).SerializeAsString(), before.objects(1).SerializeAsString());
  EXPECT_EQ(scene.recipe.objects(2).SerializeAsString(), before.objects(2).SerializeAsString());
  const v1::SceneObject& own = scene.recipe.objects(0);
  EXPECT_EQ(own.asset_class(), "own:Chair");
  const Box3f old = (*scene.pool.Get("Chair", 1))->bounds;
  const auto mesh = MakeAsset(own.asset_class(), own.seed());
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  // Back in the frame of what it replaced.
  const Eigen::Affine3d old_from_own = (FromProto(before.objects(0).world_from_object()).Inverse() *
                                        FromProto(own.world_from_object()))
                                           .Affine()
                                           .cast<double>();
  Eigen::AlignedBox3d box;
  for (const Vec3f& p : mesh->mesh.positions) box.extend(old_from_own * p.cast<double>());
  const Vec3d size = old.diagonal().cast<double>();
  EXPECT_TRUE((box.sizes().array() < size.array() + 1e-4).all()) << box.sizes().transpose();
  EXPECT_NEAR((box.sizes().array() / size.array()).maxCoeff(), 1, 1e-4) << "as large as it can be";
  EXPECT_NEAR(box.min().z(), double{old.min().z()}, 1e-4) << "on the floor";
}

TEST_F(OwnContentTest, KeyframesHaveTheirOwnSurroundings) {
  ASSERT_TRUE(WriteExrHalfRgb(dir_ + "/one/hdris/dark.exr", ImageF3(8, 4, 0.1f)).ok());
  v1::SceneConfig config = ConfigOf("one");
  config.mutable_lighting()->set_hdri_p(0.5);
  const OwnContent own = *ReadOwnContent(config);
  ASSERT_EQ(own.environments.size(), 2u);
  v1::Scene recipe;
  for (int i = 0; i < 200; ++i) recipe.add_keyframes()->mutable_sky()->set_strength(1);
  ChooseEnvironments(config.lighting(), own, SceneSeed{1}, recipe);
  std::map<uint64_t, int> counts;
  std::set<double> turns;
  for (const v1::Keyframe& keyframe : recipe.keyframes()) {
    ++counts[keyframe.sky().environment()];
    if (keyframe.sky().environment() != 0) turns.insert(keyframe.sky().environment_turn_rad());
  }
  EXPECT_NEAR(counts[0], 100, 30);
  EXPECT_NEAR(counts[own.environments[0]], 50, 25);
  EXPECT_GT(turns.size(), 50u);
  EXPECT_EQ(recipe.sky().SerializeAsString(), recipe.keyframes(0).sky().SerializeAsString());
}

TEST_F(OwnContentTest, RigsThatShareALeftEyeHaveTheSameSurroundings) {
  ASSERT_TRUE(WriteExrHalfRgb(dir_ + "/one/hdris/dark.exr", ImageF3(8, 4, 0.1f)).ok());
  const v1::SceneConfig config = ConfigOf("one");
  const OwnContent own = *ReadOwnContent(config);
  v1::Scene single, shared;
  for (int i = 0; i < 12; ++i) {
    single.add_rigs();
    single.add_keyframes()->mutable_sky()->set_strength(1);
    for (const bool shares_left : {false, true, true}) {
      shared.add_rigs()->set_shares_left(shares_left);
      shared.add_keyframes()->mutable_sky()->set_strength(1);
    }
  }
  ChooseEnvironments(config.lighting(), own, SceneSeed{1}, single);
  ChooseEnvironments(config.lighting(), own, SceneSeed{1}, shared);
  for (int i = 0; i < shared.keyframes_size(); ++i) {
    EXPECT_EQ(shared.keyframes(i).sky().SerializeAsString(),
              single.keyframes(i / 3).sky().SerializeAsString())
        << i;
  }
  v1::RenderJob job;
  *job.mutable_scene() = shared;
  job.set_hdri_dir("one/hdris");
  EXPECT_TRUE(LocateOwnContent(job).ok()) << LocateOwnContent(job);
  job.mutable_scene()->mutable_keyframes(4)->mutable_sky()->set_environment_turn_rad(7);
  EXPECT_EQ(LocateOwnContent(job).code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(LocateOwnContent(job).message()),
              HasSubstr("keyframe 4 shows other surroundings than keyframe 3"));
}

}  // namespace
}  // namespace parallax
