#include "coordinator/client/runs/out_dir.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "common/config/config.h"
#include "coordinator/client/exit_code.h"
#include "tests/folder_test.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class OutDirTest : public FolderTest {
 protected:
};

TEST_F(OutDirTest, MakesTheFolderAndLeavesNoProbe) {
  const auto out = OutDir::Open(dir_ + "/a/b/");
  ASSERT_TRUE(out.ok()) << out.status();
  EXPECT_EQ((*out)->path(), dir_ + "/a/b");
  EXPECT_TRUE(fs::is_directory((*out)->work_dir()));
  EXPECT_FALSE(fs::exists((*out)->work_dir() + "/probe"));
  EXPECT_GT((*out)->FreeBytes(), 0);
}

TEST_F(OutDirTest, IsHeldByOneAtATime) {
  {
    const auto first = OutDir::Open(dir_);
    ASSERT_TRUE(first.ok());
    const auto second = OutDir::Open(dir_);
    ASSERT_EQ(ExitCodeOf(second.status()), kExitUsage);
    EXPECT_THAT(std::string(second.status().message()),
                HasSubstr("in use by another parallax (process " + std::to_string(getpid()) + ")"));
  }
  EXPECT_TRUE(OutDir::Open(dir_).ok()) << "given back with its holder";
}

TEST_F(OutDirTest, AFileInTheWayIsNamed) {
  std::ofstream(dir_ + "/file") << "x";
  EXPECT_THAT(std::string(OutDir::Open(dir_ + "/file").status().message()),
              HasSubstr("not a folder"));
  EXPECT_THAT(std::string(OutDir::Open(dir_ + "/file/below").status().message()),
              HasSubstr("a file is in the way"));
}

TEST_F(OutDirTest, APlaceThatCannotBeWrittenIsADiskError) {
  const auto out = OutDir::Open("/proc/parallax");
  ASSERT_FALSE(out.ok());
  EXPECT_EQ(ExitCodeOf(out.status()), kExitDisk) << out.status();
  EXPECT_THAT(std::string(out.status().message()), HasSubstr("/proc/parallax"));
}

TEST_F(OutDirTest, AFolderInsideOfADatasetIsRefused) {
  fs::create_directories(dir_ + "/data/narrow");
  std::ofstream(dir_ + "/data/study.lock.yaml") << "x";
  EXPECT_TRUE(OutDir::Open(dir_ + "/data/new").ok()) << "a lock file alone is no dataset";
  std::ofstream(dir_ + "/data/narrow/index.jsonl") << "x";
  for (const char* inside : {"/data/narrow", "/data/other/", "/data/a/b"}) {
    const auto out = OutDir::Open(dir_ + inside);
    EXPECT_EQ(ExitCodeOf(out.status()), kExitUsage) << inside;
    EXPECT_THAT(std::string(out.status().message()),
                HasSubstr("lies in the dataset " + fs::canonical(dir_).string() + "/data itself"));
  }
  EXPECT_FALSE(fs::exists(dir_ + "/data/other"));
  EXPECT_TRUE(OutDir::Open(dir_ + "/data").ok()) << "the dataset is gone on with";
  EXPECT_TRUE(OutDir::Open(dir_ + "/beside").ok());
}

TEST_F(OutDirTest, ForeignFilesAreSeen) {
  EXPECT_FALSE(HoldsForeignFiles(dir_ + "/absent"));
  EXPECT_FALSE(HoldsForeignFiles(dir_));
  std::ofstream(dir_ + "/thesis.doc") << "x";
  EXPECT_TRUE(HoldsForeignFiles(dir_));
  std::ofstream(dir_ + "/study.lock.yaml") << "x";
  EXPECT_FALSE(HoldsForeignFiles(dir_)) << "a dataset of ours";
}

TEST_F(OutDirTest, PairsThatAreThereNeedNoMoreSpace) {
  const auto of_size = [](const std::string& size) {
    return *ParseStudy("study: s\npairs: 4\nrigs_per_scene: 2\nvariants: [{name: a, set: {rigs: {" +
                           size + "}}}]\n",
                       "s.yaml");
  };
  const v1::StudySpec study = of_size("width_px: 640, height_px: 360");
  EXPECT_EQ(EstimateMissingBytes(study, dir_), EstimateBytes(study));
  std::ofstream(dir_ + "/study.lock.yaml") << StudyToYaml(study);
  for (const char* frame : {"000000/000", "000000/001", "000001/000"}) {
    fs::create_directories(dir_ + "/a/frames/" + frame);
  }
  EXPECT_NEAR(4.0 * static_cast<double>(EstimateMissingBytes(study, dir_)),
              static_cast<double>(EstimateBytes(study)), 4);
  const v1::StudySpec other = of_size("width_px: 320, height_px: 180");
  EXPECT_EQ(EstimateMissingBytes(other, dir_), EstimateBytes(other)) << "those are put aside";
  fs::create_directories(dir_ + "/a/frames/000001/001");
  EXPECT_EQ(EstimateMissingBytes(study, dir_), 0);
}

TEST(EstimateBytes, GrowsWithPairsVariantsAndPixels) {
  v1::StudySpec study;
  study.set_pairs(10);
  v1::VariantSpec* variant = study.add_variants();
  variant->mutable_config()->mutable_rigs()->set_width_px(100);
  variant->mutable_config()->mutable_rigs()->set_height_px(10);
  const int64_t images_only = EstimateBytes(study);
  EXPECT_GT(images_only, 0);
  variant->mutable_config()->mutable_render()->add_maps("depth");
  EXPECT_GT(EstimateBytes(study), images_only);
  const auto grows_with = [&study](const char* what, auto change) {
    const int64_t before = EstimateBytes(study);
    change();
    EXPECT_GT(EstimateBytes(study), before) << what;
  };
  v1::RenderConfig& render = *variant->mutable_config()->mutable_render();
  grows_with("raw", [&render] { render.add_maps("raw"); });
  grows_with("infrared", [&render] { render.add_maps("infrared"); });
  grows_with("keep_hdr", [&render] { render.set_keep_hdr(true); });
  const int64_t one = EstimateBytes(study);
  *study.add_variants() = study.variants(0);
  EXPECT_NEAR(static_cast<double>(EstimateBytes(study)), 2.0 * static_cast<double>(one), 1);
}

}  // namespace
}  // namespace parallax::client
