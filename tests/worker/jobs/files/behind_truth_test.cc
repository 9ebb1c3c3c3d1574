#include "worker/jobs/files/behind_truth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/base/system/file.h"
#include "common/image/io.h"
#include "tests/folder_test.h"
#include "tests/worker/dataset/synthetic_archive.h"
#include "worker/render/camera/stereo_frame.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

// A frame with balls of glass half a metre before their second layer.
class BehindTruthTest : public FolderTest {
 protected:
  void SetUp() override {
    MakeSyntheticArchive(dir_ + "/data", {.scenes = 1, .rigs = 1, .extras = true});
    data_ = dir_ + "/data/a/frames/000000/000/";
  }

  auto Make() const {
    return MakeBehindTruth([this](const std::string& name) {
      return fs::exists(data_ + name) ? data_ + name : std::string();
    });
  }
  // Changes the numbers of frame.json.
  void Edit(const std::function<void(nlohmann::ordered_json*)>& change) const {
    auto json = nlohmann::ordered_json::parse(*ReadFile(data_ + "frame.json"));
    change(&json);
    fs::remove(data_ + "frame.json");
    ASSERT_TRUE(WriteFile(data_ + "frame.json", json.dump()).ok());
  }

  std::string data_;
};

TEST_F(BehindTruthTest, IsThatOfTheLastLayer) {
  const auto made = Make();
  ASSERT_TRUE(made.ok()) << made.status();
  int behind = 0, visible = 0;
  for (const std::string eye : {"left", "right"}) {
    const ImageU8 count = *ReadPngU8(data_ + "layers_" + eye + ".png");
    const ImageF first = *ReadExrY(data_ + "disparity_" + eye + ".exr"),
                 second = *ReadExrY(data_ + "disparity2_" + eye + ".exr"),
                 disparity = *DecodeExrY(made->at("disparity_" + eye + ".exr"));
    const ImageU16 objects = *DecodePngU16(made->at("objects_" + eye + ".png"));
    const ImageU8 masks = *DecodePngU8(made->at("masks_" + eye + ".png")),
                  old_masks = *ReadPngU8(data_ + "masks_" + eye + ".png"),
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
  const ImageU8 count = *ReadPngU8(data_ + "layers_left.png");
  const ImageU16 old = *ReadPngU16(data_ + "materials_left.png");
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
  const ImageU8 count = *ReadPngU8(data_ + "layers_left.png");
  const ImageU8 masks = *DecodePngU8(made->at("masks_left.png"));
  for (size_t i = 0; i < count.pixels(); ++i) {
    if (count.values()[i] == 2) {
      ASSERT_EQ(masks.values()[i], kMaskExterior);
    }
  }
}

TEST_F(BehindTruthTest, NamesWhatIsMissing) {
  fs::remove(data_ + "objects2_right.png");
  EXPECT_THAT(std::string(Make().status().message()), HasSubstr("no objects2_right.png"));
  fs::remove(data_ + "layers_left.png");
  EXPECT_EQ(Make().status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(Make().status().message()), HasSubstr("no layers_left.png"));
}

}  // namespace
}  // namespace parallax
