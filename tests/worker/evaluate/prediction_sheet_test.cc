#include "worker/evaluate/prediction_sheet.h"

#include <gtest/gtest.h>

#include "tests/worker/evaluate/test_tree.h"
#include "worker/dataset/sheets/drawing.h"
#include "worker/evaluate/evaluation.h"
#include "worker/evaluate/group_errors.h"

namespace parallax {
namespace {

Rgb At(const ImageRgb8& image, int x, int y) {
  return {image(x, y, 0), image(x, y, 1), image(x, y, 2)};
}

TEST(PredictionSheet, ErrorColoursTellUnknownWrongAndFar) {
  const ImageRgb8 colors = ColorError(Row({10, 15, 12.5f, kNan, 3}), Row({10, 10, 10, 10, 0}));
  EXPECT_EQ(At(colors, 0, 0), Turbo(0));
  EXPECT_EQ(At(colors, 1, 0), Turbo(1));
  EXPECT_EQ(At(colors, 2, 0), Turbo(0.5));
  const Rgb wrong = {255, 0, 255};
  EXPECT_EQ(At(colors, 3, 0), wrong);
  EXPECT_NE(At(colors, 4, 0), wrong);
  EXPECT_EQ(At(ColorPrediction(Row({kInf}), 10), 0, 0), wrong);
  EXPECT_EQ(At(ColorPrediction(Row({-1}), 10), 0, 0), wrong);
}

TEST(PredictionSheet, ColoursEndWhereTwoPercentOfThePixelsGoBeyond) {
  ImageF ramp(101, 1);
  for (int x = 0; x <= 100; ++x) ramp(x, 0) = static_cast<float>(x);
  EXPECT_EQ(ColorScale(ramp), 98);
  EXPECT_EQ(ColorScale(Row({kNan, kInf, -1, 0, 5})), 5);
  EXPECT_EQ(ColorScale(Row({0, kNan})), 1);
}

TEST(PredictionSheet, DrawsTheWorstPairsFirstAndNeedsTheirPredictions) {
  const TestTree tree;
  for (int i = 0; i < 4; ++i) {
    const std::string name(1, static_cast<char>('a' + i));
    tree.Pictures("pairs/" + name + "/im0.png", "pairs/" + name + "/im1.png", 40, 20);
    tree.Pfm("pairs/" + name + "/disp0GT.pfm", ImageF(40, 20, 10.0f));
    ImageF predicted(40, 20, 10.0f);
    for (int x = 0; x < 10 * i; ++x) predicted(x, 3) = 20;  // d is worst.
    tree.Pfm("predictions/" + name + ".pfm", predicted);
  }
  const auto benchmark = OpenBenchmark("folder:" + tree.dir() + "/pairs", "");
  ASSERT_TRUE(benchmark.ok()) << benchmark.status();
  const std::string work = tree.dir() + "/work";
  const auto evaluation = Evaluate(*MakeFolderPredictor(tree.dir() + "/predictions"), *benchmark,
                                   {.work_dir = work, .keep_predictions = true});
  ASSERT_TRUE(evaluation.ok()) << evaluation.status();
  const std::string png = tree.Path("sheet.png");
  const PredictionSheetOptions two = {.best = 1, .worst = 1, .tile_width_px = 200};
  ASSERT_TRUE(DrawPredictionSheet(*benchmark, *evaluation, work, png, two).ok());
  const auto small = ReadPngRgb8(png);
  ASSERT_TRUE(small.ok());
  ASSERT_TRUE(DrawPredictionSheet(*benchmark, *evaluation, work, png).ok());
  EXPECT_GT(ReadPngRgb8(png)->height(), small->height());
  // Rows d and a are drawn: the predictions of b and c are not needed, that of d is.
  std::filesystem::remove(PredictionPath(work, "b"));
  EXPECT_TRUE(DrawPredictionSheet(*benchmark, *evaluation, work, png, two).ok());
  std::filesystem::remove(PredictionPath(work, "d"));
  // The best alone is a, the worst alone d.
  EXPECT_TRUE(
      DrawPredictionSheet(*benchmark, *evaluation, work, png, {.best = 1, .worst = 0}).ok());
  EXPECT_FALSE(
      DrawPredictionSheet(*benchmark, *evaluation, work, png, {.best = 0, .worst = 1}).ok());
  EXPECT_EQ(DrawPredictionSheet(*benchmark, *evaluation, work, png, two).code(),
            absl::StatusCode::kNotFound);
}

TEST(GroupErrors, BarsAreAsLongAsTheirErrors) {
  const TestTree tree;
  const std::vector<GroupError> errors = {{"glass", 0.1, {.pixels = 100, .abs_error_px = 800}},
                                          {"wood", 0.9, {.pixels = 900, .abs_error_px = 1800}}};
  ASSERT_TRUE(DrawGroupErrors(errors, "title", tree.Path("bars.png")).ok());
  const auto image = ReadPngRgb8(tree.Path("bars.png"));
  ASSERT_TRUE(image.ok());
  const auto accent = [&](int y) {
    int count = 0;
    for (int x = 0; x < image->width(); ++x) count += At(*image, x, y) == kAccent;
    return count;
  };
  // Means of 8 and 2 px: the second bar is a quarter as long.
  EXPECT_GT(accent(90), 100);
  EXPECT_NEAR(accent(90 + 24), accent(90) / 4.0, 1);
}

}  // namespace
}  // namespace parallax
