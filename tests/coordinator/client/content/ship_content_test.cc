#include "coordinator/client/content/ship_content.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/base/system/file.h"
#include "common/config/config.h"
#include "common/config/content_folders.h"
#include "common/image/io.h"
#include "common/store/content.h"
#include "common/store/store.h"
#include "coordinator/client/content/study_options.h"
#include "tests/folder_test.h"
#include "worker/evaluate/own_benchmark.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST(NameOwnCopies, ListsOfAStoreBecomeThePathsTheyStandFor) {
  v1::StudySpec study;
  v1::SceneConfig& config = *study.add_variants()->mutable_config();
  config.mutable_lighting()->set_hdri_dir(
      ContentReferenceText({std::string(64, 'a'), "srv/hdris"}));
  config.mutable_assets()->add_include("srv/chairs");
  config.mutable_assets()->add_include(ContentReferenceText({std::string(64, 'b'), "srv/tables"}));
  NameOwnCopies(study);
  EXPECT_EQ(config.lighting().hdri_dir(), "srv/hdris");
  EXPECT_EQ(config.assets().include(0), "srv/chairs");
  EXPECT_EQ(config.assets().include(1), "srv/tables");
  EXPECT_FALSE(config.has_materials());
}

// Returns memory_mb of a study whose only texture is a square of `side_px`.
int64_t MemoryForTexture(int side_px) {
  std::string dir = testing::TempDir() + "/large_texture_XXXXXX";
  if (mkdtemp(dir.data()) == nullptr) return -1;
  v1::StudySpec study;
  study.set_memory_mb(64);
  study.add_variants()->mutable_config()->mutable_materials()->set_texture_dir(dir.substr(1));
  const bool written =
      WriteFile(dir + "/brick_albedo.png", *EncodePng(ImageRgb8(side_px, side_px))).ok();
  const absl::Status status = HashContent(study, FolderReaders::kOfFarm);
  EXPECT_TRUE(written && status.ok()) << status;
  fs::remove_all(dir);
  return study.memory_mb();
}

TEST(HashContent, LargeTexturesAskForWorkersThatHoldThem) {
  EXPECT_EQ(MemoryForTexture(64), 64);
  // Three bytes a pixel, twice, beside a scene.
  EXPECT_GE(MemoryForTexture(8000), 1024 + 2 * 3 * 8000 * 8000 / (1 << 20));
}

using OwnClassesTest = FolderTest;

TEST_F(OwnClassesTest, AClassThatNoFolderHasIsNamedBeforeAnyWork) {
  fs::create_directories(dir_ + "/mine/chairs");
  std::ofstream(dir_ + "/mine/chairs/a.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  v1::StudySpec study;
  v1::SceneConfig& config = *study.add_variants()->mutable_config();
  config.mutable_assets()->add_include(dir_.substr(1) + "/mine");
  for (const char* name : {"own", "own:chairs", "Chair"}) {
    config.mutable_floating()->add_classes(name);
  }
  EXPECT_TRUE(HashContent(study, FolderReaders::kOfRun).ok());
  config.mutable_floating()->add_classes("own:chair");
  EXPECT_THAT(
      HashContent(study, FolderReaders::kOfRun).ToString(),
      HasSubstr("floating.classes: assets.include has no mesh of \"own:chair\", did you mean "
                "own:chairs? (allowed: own:chairs)"));
  config.mutable_floating()->clear_classes();
  config.mutable_assets()->add_weights()->set_class_("own:a");
  EXPECT_THAT(HashContent(study, FolderReaders::kOfRun).ToString(),
              HasSubstr("assets.weights: assets.include has no mesh of \"own:a\""));
}

// A folder with a pair in Middlebury's layout and a list that names its files from elsewhere.
class OwnBenchmarkTest : public FolderTest {
 protected:
  void SetUp() override {
    for (const char* folder : {"/real/yard one", "/lists", "/store"}) {
      fs::create_directories(dir_ + folder);
    }
    const std::string pair = dir_ + "/real/yard one/";
    for (const char* file : {"im0.png", "im1.png"}) {
      ASSERT_TRUE(WriteFile(pair + file, *EncodePng(ImageRgb8(40, 30))).ok());
    }
    ImageF truth(40, 30);
    truth.values().assign(truth.pixels(), 3.0f);
    ASSERT_TRUE(WritePfm(pair + "disp0GT.pfm", truth).ok());
    fs::copy(pair, dir_ + "/plain", fs::copy_options::recursive);
    std::ofstream(dir_ + "/lists/pairs.txt")
        << "# mine\n../plain/im0.png " << dir_ << "/plain/im1.png ../plain/disp0GT.pfm\n";
    auto study = ParseStudy(
        "study: s\npairs: 1\nvariants: [{name: a}]\nevaluate:\n  benchmarks:\n"
        "    - {name: mine, list: lists/pairs.txt}\n    - {name: yard, folder: real}\n",
        dir_ + "/s.yaml");
    ASSERT_TRUE(study.ok()) << study.status();
    study_ = *study;
  }

  v1::StudySpec study_;
};

TEST_F(OwnBenchmarkTest, IsShippedAndOpensFromItsCopyAsFromItsPlace) {
  ASSERT_TRUE(HashContent(study_, FolderReaders::kOfFarm).ok());
  const auto store = OpenStore(dir_ + "/store");
  ASSERT_TRUE(store.ok()) << store.status();
  v1::StudySpec sent = study_;
  const auto shipped = ShipContent(sent, **store);
  ASSERT_TRUE(shipped.ok()) << shipped.status();
  EXPECT_EQ(shipped->folders, 2);
  for (int i = 0; i < 2; ++i) {
    const v1::OwnBenchmark& own = sent.evaluate().own_benchmarks(i);
    const auto reference = FindContentReference(PathOfBenchmark(own));
    ASSERT_TRUE(reference.has_value()) << PathOfBenchmark(own);
    EXPECT_EQ(reference->sha256, own.sha256());
    const auto files = ParseContentList(*(*store)->Get(ContentPath(reference->sha256)));
    ASSERT_TRUE(files.ok()) << files.status();
    const std::string copy = dir_ + "/copy/" + own.name() + "/real";
    for (const ContentFile& file : *files) {
      fs::create_directories(fs::path(copy + "/" + file.name).parent_path());
      ASSERT_TRUE(WriteFile(copy + "/" + file.name, *(*store)->Get(ContentPath(file.sha256))).ok());
    }
    const auto here = OpenOwnBenchmark(own, "/" + reference->path);
    const auto there = OpenOwnBenchmark(own, copy);
    ASSERT_TRUE(here.ok()) << here.status();
    ASSERT_TRUE(there.ok()) << there.status();
    ASSERT_EQ(there->pairs.size(), 1u);
    EXPECT_EQ(there->pairs[0].name, here->pairs[0].name);
    EXPECT_EQ(there->pairs[0].read_truth()->disparity_px.values()[0], 3.0f);
  }
  NameOwnCopies(sent);
  EXPECT_EQ(sent.evaluate().SerializeAsString(), study_.evaluate().SerializeAsString());
}

TEST_F(OwnBenchmarkTest, OtherContentIsSaidAndNotScored) {
  ASSERT_TRUE(HashContent(study_, FolderReaders::kOfRun).ok());
  const v1::OwnBenchmark own = study_.evaluate().own_benchmarks(0);
  ASSERT_TRUE(WriteFile(dir_ + "/plain/im1.png", *EncodePng(ImageRgb8(40, 31))).ok());
  EXPECT_THAT(OpenOwnBenchmark(own, "/" + own.list()).status().ToString(),
              HasSubstr("benchmark mine: the content of "));
  EXPECT_THAT(HashContent(study_, FolderReaders::kOfRun).ToString(),
              HasSubstr("is not that of sha256"));
  study_.mutable_evaluate()->mutable_own_benchmarks(0)->clear_sha256();
  fs::remove(dir_ + "/plain/disp0GT.pfm");
  EXPECT_THAT(HashContent(study_, FolderReaders::kOfRun).ToString(),
              HasSubstr("evaluate.benchmarks: mine: "));
  fs::remove(dir_ + "/lists/pairs.txt");
  EXPECT_THAT(HashContent(study_, FolderReaders::kOfRun).ToString(),
              HasSubstr("no file of this path beside the study's file"));
}

}  // namespace
}  // namespace parallax::client
