// Faults that `verify` finds in layers.
#include "worker/dataset/verify/verify_layers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "common/base/system/file.h"
#include "common/image/io.h"
#include "tests/folder_test.h"
#include "tests/worker/dataset/synthetic_archive.h"
#include "worker/dataset/archive/dataset_reader.h"
#include "worker/dataset/verify/verify.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class VerifyLayersTest : public FolderTest {
 protected:
  void SetUp() override {
    MakeSyntheticArchive(dir_ + "/data", {.scenes = 1, .rigs = 1, .extras = true});
    frame_ = dir_ + "/data/a/frames/000000/000/";
    const ImageU8 count = *ReadPngU8(frame_ + "layers_left.png");
    while (count.values()[clear_] != 2) ++clear_;
    while (count.values()[opaque_] != 1) ++opaque_;
  }

  // All findings, each a line "check file: message".
  std::string Found() {
    const DatasetFrame index = ReadDataset(dir_ + "/data")->variants.at(0).frames.at(0);
    std::vector<Finding> findings;
    std::optional<CheckedFrame> frame = ReadNumbers(index, findings);
    ReadMaps(*frame);
    CheckLayers(*frame);
    std::string text;
    for (const Finding& finding : findings) {
      text += finding.check + " " + fs::path(finding.path).filename().string() + ": " +
              finding.message + "\n";
    }
    return text;
  }

  template <typename ImageType>
  void Write(const std::string& name, const ImageType& image) {
    fs::remove(frame_ + name);  // The file is a link to the store's.
    if constexpr (std::is_same_v<ImageType, ImageF>) {
      ASSERT_TRUE(WriteExrY(frame_ + name, image).ok());
    } else {
      ASSERT_TRUE(WritePng(frame_ + name, image).ok());
    }
  }

  std::string frame_;
  size_t clear_ = 0, opaque_ = 0;  // Pixels with and without a second layer.
};

TEST_F(VerifyLayersTest, GoodOnesHaveNoFindings) {
  EXPECT_THAT(Found(), IsEmpty());
  const auto whole = VerifyDataset(dir_ + "/data", {});
  ASSERT_TRUE(whole.ok()) << whole.status();
  for (const Finding& finding : whole->findings) {
    EXPECT_NE(finding.check, "layers") << finding.path << finding.message;
  }
}

TEST_F(VerifyLayersTest, EachLiesBehindTheOneBefore) {
  ImageF depth = *ReadExrY(frame_ + "depth2_left.exr");
  depth.values()[clear_] = ReadExrY(frame_ + "depth_left.exr")->values()[clear_];
  Write("depth2_left.exr", depth);
  EXPECT_THAT(Found(), HasSubstr("layers depth2_left.exr: 1 of"));
}

TEST_F(VerifyLayersTest, DisparityFollowsFromDepth) {
  ImageF disparity = *ReadExrY(frame_ + "disparity2_right.exr");
  const ImageU8 count = *ReadPngU8(frame_ + "layers_right.png");
  size_t pixel = 0;
  while (count.values()[pixel] != 2) ++pixel;
  disparity.values()[pixel] *= 1.001f;
  Write("disparity2_right.exr", disparity);
  EXPECT_THAT(Found(), HasSubstr("layers disparity2_right.exr: 1 of"));
}

TEST_F(VerifyLayersTest, NothingIsBehindWhatIsOpaque) {
  ImageU8 count = *ReadPngU8(frame_ + "layers_left.png");
  count.values()[opaque_] = 2;
  Write("layers_left.png", count);
  ImageF depth = *ReadExrY(frame_ + "depth2_left.exr");
  depth.values()[opaque_] = 99;
  Write("depth2_left.exr", depth);
  const std::string found = Found();
  EXPECT_THAT(found, HasSubstr("layers materials2_left.png: 1 of"));
  EXPECT_THAT(found, HasSubstr("which is opaque"));
  EXPECT_THAT(found, HasSubstr("layers objects2_left.png: 1 of")) << "object 0";
}

TEST_F(VerifyLayersTest, CountAgreesWithTheFirstMapsAndWithTheFiles) {
  ImageU8 count = *ReadPngU8(frame_ + "layers_left.png");
  count.values()[opaque_] = 0;
  Write("layers_left.png", count);
  EXPECT_THAT(Found(), HasSubstr("layers layers_left.png: 1 of"));
  count.values()[opaque_] = 128 + 2;  // More than four, but two.
  Write("layers_left.png", count);
  EXPECT_THAT(Found(), HasSubstr("layers layers_left.png: 1 of"));
  count.values()[opaque_] = 1;
  count.values()[clear_] = 3;
  Write("layers_left.png", count);
  EXPECT_THAT(Found(), HasSubstr("layers depth3_left.exr: missing"));
  fs::remove(frame_ + "disparity2_right.exr");
  EXPECT_THAT(Found(), HasSubstr("layers disparity2_right.exr: missing"));
}

}  // namespace
}  // namespace parallax
