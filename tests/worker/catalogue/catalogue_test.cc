// The catalogue's listing and its contact sheets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "common/image/io.h"
#include "common/image/jpeg.h"
#include "worker/assets/asset.h"
#include "worker/catalogue/figures.h"
#include "worker/catalogue/sheet.h"

namespace parallax {
namespace {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;

TEST(Figures, TellWhatAClassCostsAndHowLargeItIs) {
  const AssetFigures figures = MeasureAssetClass(*FindAssetClass("Cup"), 5);
  ASSERT_EQ(figures.ms.size(), 5u);
  EXPECT_GT(figures.ms.front(), 0);
  EXPECT_GE(figures.ms.back(), figures.median_ms);
  EXPECT_GT(figures.median_triangles, 100u);
  EXPECT_GE(figures.most_triangles, figures.median_triangles);
  EXPECT_EQ(figures.most_m, FindAssetClass("Cup")->size.most_m);
  EXPECT_TRUE((figures.smallest_m.array() >= figures.least_m.array()).all());
  EXPECT_TRUE((figures.largest_m.array() <= figures.most_m.array()).all());
  EXPECT_THAT(figures.slots, ElementsAre("body"));
}

TEST(Figures, TellWhatAMaterialCosts) {
  const MaterialClass& wood = *MaterialsOfFamily("wood").front();
  const MaterialFigures figures = MeasureMaterialClass(wood);
  EXPECT_GT(figures.evaluate_ns, 1);
  EXPECT_LT(figures.evaluate_ns, 1e6);
  EXPECT_GT(figures.height_ns, 0);
}

TEST(Figures, GivePercentilesOfWhatIsThere) {
  EXPECT_EQ(Percentile({}, 0.5), 0);
  EXPECT_EQ(Percentile({1, 2, 3, 4}, 0.5), 2);
  EXPECT_EQ(Percentile({1, 2, 3, 4}, 0.95), 4);
  EXPECT_EQ(Percentile({1, 2, 3, 4}, 0), 1);
}

class Sheets : public testing::Test {
 protected:
  Sheets() {
    options_.dir = testing::TempDir() + "sheets_" +
                   testing::UnitTest::GetInstance()->current_test_info()->name();
    options_.cell_px = 40;
    options_.samples = 2;
  }
  ~Sheets() override { std::filesystem::remove_all(options_.dir); }

  SheetOptions options_;
};

// Mean absolute difference of two cells of the first row, in 8-bit steps.
double CellDifference(const ImageRgb8& page, int cell_px, int a, int b) {
  const int caption = page.height() - cell_px;
  double sum = 0;
  for (int y = caption; y < page.height(); ++y) {
    for (int i = 0; i < 3 * cell_px; ++i) {
      sum += std::abs(static_cast<int>(page.At(a * cell_px, y)[i]) -
                      static_cast<int>(page.At(b * cell_px, y)[i]));
    }
  }
  return sum / (3.0 * cell_px * cell_px);
}

TEST_F(Sheets, ShowAClassInSixSeedsAndAMaterialOnThreeBodies) {
  options_.only = {"Vase", MaterialsOfFamily("wood").front()->name};
  const absl::StatusOr<SheetResult> result = WriteCatalogueSheets(options_, {});
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->classes, 1);
  EXPECT_EQ(result->materials, 1);
  EXPECT_THAT(result->files, ElementsAre(EndsWith("assets-01.png"), EndsWith("materials-01.png"),
                                         EndsWith("assets.jpg"), EndsWith("materials.jpg")));
  for (const std::string& file : result->files) {
    const absl::StatusOr<ImageRgb8> page = ReadPictureRgb8(file);
    ASSERT_TRUE(page.ok()) << page.status();
    if (file.find("-01") == std::string::npos) continue;
    EXPECT_EQ(page->width(), 6 * options_.cell_px);
    // Every cell shows something else.
    for (int k = 1; k < 6; ++k) EXPECT_GT(CellDifference(*page, options_.cell_px, k - 1, k), 2.0);
  }
}

TEST_F(Sheets, SayWhatHasNoSuchName) {
  options_.only = {"Unicorn"};
  const absl::StatusOr<SheetResult> result = WriteCatalogueSheets(options_, {});
  ASSERT_EQ(result.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(result.status().message()), HasSubstr("'Unicorn'"));
}

TEST_F(Sheets, StopWhenTold) {
  options_.only = {"Vase"};
  CancelToken cancel;
  cancel.Cancel();
  EXPECT_EQ(WriteCatalogueSheets(options_, cancel).status().code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace parallax
