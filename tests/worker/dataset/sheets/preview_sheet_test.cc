#include "worker/dataset/sheets/preview_sheet.h"

#include <gtest/gtest.h>

#include <set>

#include "worker/dataset/sheets/drawing.h"

namespace parallax {
namespace {

constexpr Rgb kRed = {200, 10, 10}, kGreen = {10, 200, 10}, kBlue = {10, 10, 200};

ImageRgb8 Plain(const Rgb& color) {
  ImageRgb8 image(320, 180);
  for (size_t i = 0; i < image.pixels(); ++i) std::copy_n(color.begin(), 3, image.data() + 3 * i);
  return image;
}

PreviewRow RowOf(const std::string& name, float disparity_px) {
  auto pair = std::make_shared<PreviewPair>();
  pair->rig.set_width_px(1280);
  pair->rig.set_height_px(720);
  pair->left = Plain(kRed);
  pair->right = Plain(kGreen);
  pair->disparity_px = ImageF(320, 180);
  for (float& value : pair->disparity_px.values()) value = disparity_px;
  pair->disparities = FiguresOf(pair->disparity_px);
  return {name, pair, ""};
}

// Pixels of exactly this colour.
int64_t Count(const ImageRgb8& image, const Rgb& color) {
  int64_t count = 0;
  for (size_t i = 0; i < image.pixels(); ++i) {
    count += std::equal(color.begin(), color.end(), image.data() + 3 * i);
  }
  return count;
}

TEST(PreviewSheet, HasARowForEachVariantAndAColumnForEachPicture) {
  const ImageRgb8 one = DrawPreviewSheet({"title", "below", ""}, {RowOf("a", 20)});
  const std::vector<PreviewRow> rows = {RowOf("a", 20), RowOf("b", 40), {"c", nullptr, "no scene"}};
  const ImageRgb8 sheet = DrawPreviewSheet({"title", "below", "not shown: d"}, rows);
  EXPECT_EQ(sheet.width(), one.width());
  EXPECT_GT(sheet.height(), one.height() + 180);
  EXPECT_EQ(Count(sheet, kRed), 2 * 320 * 180);
  EXPECT_EQ(Count(sheet, kGreen), 2 * 320 * 180);
}

TEST(PreviewSheet, OneScaleOfColoursServesAllRowsAndEndsWhereTrainersDo) {
  EXPECT_EQ(ScaleOf({}).high_px, 1);
  EXPECT_EQ(ScaleOf({{"c", nullptr, "no scene"}}).high_px, 1);
  const DisparityScale scale = ScaleOf({RowOf("a", 20), RowOf("b", 0.5f), RowOf("c", 80)});
  EXPECT_EQ(scale.low_px, 20);
  EXPECT_EQ(scale.high_px, 80);
  EXPECT_EQ(ScaleOf({RowOf("a", 20), RowOf("b", 400)}).high_px, 20);
  const ImageRgb8 sheet = DrawPreviewSheet({}, {RowOf("a", 20), RowOf("b", 45), RowOf("c", 80)});
  for (const double place : {0.0, 0.5, 1.0}) {
    EXPECT_GE(Count(sheet, Turbo(place)), 320 * 180) << place << ", by square roots";
  }
}

TEST(PreviewSheet, LimitsOfTrainersAreMarked) {
  constexpr Rgb kWhite = {255, 255, 255}, kGrey = {120, 120, 120};
  const ImageRgb8 far = DrawPreviewSheet({}, {RowOf("a", 0.9f)});
  EXPECT_GE(Count(far, kGrey), 320 * 180);
  EXPECT_EQ(Count(far, kWhite), 0);
  const ImageRgb8 near = DrawPreviewSheet({}, {RowOf("a", 193)});
  EXPECT_GE(Count(near, kWhite), 320 * 180);
  const ImageRgb8 between = DrawPreviewSheet({}, {RowOf("a", 192)});
  EXPECT_EQ(Count(between, kWhite), 0);
}

TEST(PreviewSheet, RawPicturesHaveTheRowsOfTheRectifiedPair) {
  PreviewRow row = RowOf("a", 20);
  auto pair = std::make_shared<PreviewPair>(*row.pair);
  v1::Rig& rig = pair->rig;
  rig.set_fx_px(900);
  rig.set_fy_px(900);
  rig.set_cx_px(640);
  rig.set_cy_px(360);
  for (v1::RawCamera* raw : {rig.mutable_raw_left(), rig.mutable_raw_right()}) {
    raw->set_width_px(1280);
    raw->set_height_px(720);
    raw->set_fx_px(900);
    raw->set_fy_px(900);
    raw->set_cx_px(640);
    raw->set_cy_px(360);
    raw->set_qw(1);
  }
  pair->raw_left = pair->raw_right = Plain(kBlue);
  row.pair = pair;
  const ImageRgb8 sheet = DrawPreviewSheet({}, {row});
  EXPECT_GT(sheet.height(), DrawPreviewSheet({}, {RowOf("a", 20)}).height() + 180);
  // Seven straight lines through each of two pictures.
  EXPECT_EQ(Count(sheet, kBlue), 2 * (320 * 180 - 7 * 320));
}

}  // namespace
}  // namespace parallax
