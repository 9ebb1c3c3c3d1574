#include "worker/dataset/sheets/contact_sheet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "common/base/system/file.h"
#include "common/config/config.h"
#include "common/image/io.h"
#include "tests/worker/dataset/synthetic_archive.h"
#include "tests/worker/dataset/synthetic_scene.h"
#include "worker/dataset/frame/frame_writer.h"
#include "worker/dataset/sheets/drawing.h"
#include "worker/dataset/sheets/variant_sheet.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

class ContactSheetTest : public ::testing::Test {
 protected:
  void SetUp() override {
    dir_ = ::testing::TempDir() + "contact_sheet_" +
           ::testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(dir_);
  }
  void TearDown() override {
    // PARALLAX_KEEP=1 leaves the pictures for a look.
    if (std::getenv("PARALLAX_KEEP") == nullptr) fs::remove_all(dir_);
  }
  void WriteFrames(int count, int width, int height, const v1::RenderConfig& render) {
    const v1::Scene scene = MakeSyntheticScene(count, width, height);
    for (int i = 0; i < count; ++i) {
      const auto result =
          WriteFrame({.scene = scene,
                      .rig = scene.rigs(i),
                      .frame = RenderSyntheticFrame(scene, scene.rigs(i)),
                      .render = render,
                      .dir = dir_ + "/data/indoor/frames/000000/00" + std::to_string(i),
                      .store_path = "x"});
      ASSERT_TRUE(result.ok()) << result.status();
    }
  }
  std::string dir_;
};

TEST_F(ContactSheetTest, DrawsARowAFrameAndAPageOfHistograms) {
  WriteFrames(3, 640, 360, DefaultSceneConfig().render());
  const auto result = MakeContactSheet(dir_ + "/data", dir_ + "/sheet.png", {.max_frames = 2});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->frames, 2);
  EXPECT_EQ(result->frames_found, 3);
  EXPECT_GE(result->warp_median_difference, 0);
  EXPECT_LT(result->warp_median_difference, 1);
  EXPECT_EQ(result->histogram_png, dir_ + "/sheet_histograms.png");
  const ImageRgb8 sheet = *ReadPngRgb8(result->sheet_png);
  EXPECT_GT(sheet.width(), 7 * 360);
  EXPECT_GT(sheet.height(), 2 * 203);
  EXPECT_FALSE(ReadPngRgb8(result->histogram_png)->empty());
}

TEST_F(ContactSheetTest, MapsThatNoFrameHasGetNoColumn) {
  v1::RenderConfig render = DefaultSceneConfig().render();
  render.clear_maps();
  WriteFrames(1, 64, 36, render);
  const auto result = MakeContactSheet(dir_ + "/data", dir_ + "/sheet.png");
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->warp_median_difference, -1);
  const ImageRgb8 sheet = *ReadPngRgb8(result->sheet_png);
  EXPECT_LT(sheet.width(), 3 * 360) << "two images only";
  EXPECT_GT(sheet.width(), 2 * 360);
}

// One variant has three times the disparities of the other.
TEST_F(ContactSheetTest, VariantsShareTheScaleOfTheLargestDisparities) {
  MakeSyntheticArchive(dir_ + "/data", {.variants = {"narrow", "wide"}, .scenes = 1, .rigs = 1});
  const auto sheet = [&] {
    const auto result =
        MakeVariantSheet(dir_ + "/data", dir_ + "/sheet.png", {.tile_width_px = 96});
    EXPECT_TRUE(result.ok()) << result.status();
    EXPECT_EQ(result->full_scale_px.size(), 1u);
    return result->full_scale_px.at(0);
  };
  const double before = sheet();
  const std::string map = dir_ + "/data/wide/frames/000000/000/disparity_left.exr";
  ImageF disparity_px = *ReadExrY(map);
  for (float& value : disparity_px.values()) value *= 3;
  fs::remove(map);
  ASSERT_TRUE(WriteExrY(map, disparity_px).ok());
  EXPECT_NEAR(sheet(), 3 * before, 1e-3 * before);
}

TEST_F(ContactSheetTest, AFolderWithoutFramesIsNotFound) {
  fs::create_directories(dir_);
  const absl::Status status = MakeContactSheet(dir_, dir_ + "/sheet.png").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(std::string(status.message()), dir_ + ": no frame (a folder with frame.json) in it");
  EXPECT_FALSE(MakeContactSheet(dir_ + "/no", dir_ + "/sheet.png").ok());
}

TEST_F(ContactSheetTest, BrokenFramesAreErrors) {
  WriteFrames(1, 64, 36, DefaultSceneConfig().render());
  const std::string frame = dir_ + "/data/indoor/frames/000000/000";
  fs::remove(frame + "/objects_left.png");
  ASSERT_TRUE(WritePng(frame + "/objects_left.png", ImageU16(8, 8)).ok());
  EXPECT_EQ(MakeContactSheet(dir_, dir_ + "/s.png").status().code(), absl::StatusCode::kDataLoss);
  fs::remove(frame + "/frame.json");
  ASSERT_TRUE(WriteFile(frame + "/frame.json", "{").ok());
  EXPECT_EQ(MakeContactSheet(dir_, dir_ + "/s.png").status().code(), absl::StatusCode::kDataLoss);
}

TEST(Drawing, NeighbouringIndicesHaveDistinctColours) {
  for (uint32_t i = 1; i < 300; ++i) {
    const Rgb a = IndexColor(i), b = IndexColor(i + 1);
    int difference = 0;
    for (size_t c = 0; c < 3; ++c) difference += std::abs(a[c] - b[c]);
    EXPECT_GT(difference, 60) << i;
    EXPECT_NE(a, (Rgb{0, 0, 0}));
  }
}

TEST(Drawing, TurboRunsFromBlueToRed) {
  EXPECT_GT(Turbo(0.1)[2], Turbo(0.1)[0]);
  EXPECT_GT(Turbo(0.9)[0], Turbo(0.9)[2]);
  EXPECT_EQ(Turbo(-1), Turbo(0));
  EXPECT_EQ(Turbo(2), Turbo(1));
}

TEST(Drawing, TextLeavesInkInsideTheCanvasAndFits) {
  Canvas canvas(100, 30);
  canvas.DrawText(-5, 20, "Chair_3 \xc3\xa9", 10);
  canvas.DrawText(90, 28, "clipped at the edge", 12);
  int bright = 0;
  for (const uint8_t value : canvas.image().values()) bright += value > 150;
  EXPECT_GT(bright, 50);
  EXPECT_LE(Canvas::TextWidth(FitText("a very long name of an object", 8, 60), 8), 60);
  EXPECT_EQ(FitText("short", 8, 100), "short");
}

}  // namespace
}  // namespace parallax
