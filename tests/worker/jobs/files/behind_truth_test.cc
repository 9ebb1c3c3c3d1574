#include "worker/jobs/files/behind_truth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/base/system/file.h"
#include "common/image/io.h"
#include "tests/worker/dataset/synthetic_archive.h"
#include "worker/render/camera/stereo_frame.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// A frame with balls of glass half a metre before their second layer.
class BehindTruthTest : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = ::testing::TempDir() + "behind_" +
            ::testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(root_);
    fs::create_directories(root_);
    SyntheticArchive archive;
    archive.scenes = archive.rigs = 1;
    archive.extras = true;
    MakeSyntheticArchive(root_ + "/data", archive);
    dir_ = root_ + "/data/a/frames/000000/000/";
  }
  void TearDown() override { fs::remove_all(root_); }

  auto Make() const {
    return MakeBehindTruth([this](const std::string& name) {
      return fs::exists(dir_ + name) ? dir_ + name : std::string();
    });
  }
  // Changes the numbers of frame.json.
  void Edit(const std::function<void(nlohmann::ordered_json*)>& change) const {
    auto json = nlohmann::ordered_json::parse(*ReadFile(dir_ + "frame.json"));
    change(&json);
    fs::remove(dir_ + "frame.json");
    ASSERT_TRUE(WriteFile(dir_ + "frame.json", json.dump()).ok());
  }

  std::string root_, dir_;
};

TEST_F(BehindTruthTest, IsThatOfTheLastLayer) {
  const auto made = Make();
  ASSERT_TRUE(made.ok()) << made.status();
  int behind = 0, visible = 0;
  for (const std::string eye : {"left", "right"}) {
    const ImageU8 count = *ReadPngU8(dir_ + "layers_" + eye + ".png");
    const ImageF first = *ReadExrY(dir_ + "disparity_" + eye + ".exr"),
                 second = *ReadExrY(dir_ + "disparity2_" + eye + ".exr"),
                 disparity = *DecodeExrY(made->at("disparity_" + eye + ".exr"));
    const ImageU16 objects = *DecodePngU16(made->at("objects_" + eye + ".png"));
    const ImageU8 masks = *DecodePngU8(made->at("masks_" + eye + ".png")),
                  old_masks = *ReadPngU8(dir_ + "masks_" + eye + ".png"),
                  occlusion = *DecodePngU8(made->at("occlusion_" + eye + ".png"));
    for (size_t i = 0; i < count.pixels(); ++i) {
      const bool two = count.values()[i] == 2;
      ASSERT_EQ(disparity.values()[i], (two ? second : first).values()[i]);
      ASSERT_EQ(masks.values()[i], two ? 0 : old_masks.values()[i]);
      if (two) {
        ASSERT_EQ(objects.values()[i], 2);
      }
      behind += two;
      visible += two && occlusion.values()[i] == 0;
    }
  }
  EXPECT_GT(behind, 100);
  EXPECT_GT(visible, behind / 2);
}

TEST_F(BehindTruthTest, IsNoneWhereTheLastLayerIsSeeThroughToo) {
  Edit([](auto* json) { (*json)["materials"]["2"]["clear"] = "thin_glass"; });
  const auto made = Make();
  ASSERT_TRUE(made.ok()) << made.status();
  const ImageU8 count = *ReadPngU8(dir_ + "layers_left.png");
  const ImageU16 old = *ReadPngU16(dir_ + "materials_left.png");
  const ImageF disparity = *DecodeExrY(made->at("disparity_left.exr"));
  const ImageU8 masks = *DecodePngU8(made->at("masks_left.png"));
  for (size_t i = 0; i < count.pixels(); ++i) {
    const bool clear = count.values()[i] == 2 || old.values()[i] == 2;
    if (!clear) continue;
    ASSERT_EQ(disparity.values()[i], 0);
    ASSERT_EQ(masks.values()[i], kMaskSky);
  }
}

TEST_F(BehindTruthTest, KnowsTheExteriorOfRooms) {
  Edit([](auto* json) { (*json)["layers"]["interiors_m"] = {{{900, 900, 900}, {901, 901, 901}}}; });
  const auto made = Make();
  ASSERT_TRUE(made.ok()) << made.status();
  const ImageU8 count = *ReadPngU8(dir_ + "layers_left.png");
  const ImageU8 masks = *DecodePngU8(made->at("masks_left.png"));
  for (size_t i = 0; i < count.pixels(); ++i) {
    if (count.values()[i] == 2) {
      ASSERT_EQ(masks.values()[i], kMaskExterior);
    }
  }
}

TEST_F(BehindTruthTest, NamesWhatIsMissing) {
  fs::remove(dir_ + "objects2_right.png");
  EXPECT_THAT(std::string(Make().status().message()), HasSubstr("no objects2_right.png"));
  fs::remove(dir_ + "layers_left.png");
  EXPECT_EQ(Make().status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(Make().status().message()), HasSubstr("no layers_left.png"));
}

}  // namespace
}  // namespace parallax
