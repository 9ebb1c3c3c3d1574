#include "worker/train/hidden_pixels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace parallax {
namespace {

ImageF RowOf(const std::vector<float>& values) {
  ImageF row(static_cast<int>(values.size()), 1);
  std::copy(values.begin(), values.end(), row.values().begin());
  return row;
}

TEST(HiddenPixels, AreFilledFromTheBackgroundBesideThem) {
  // A strip of disparity 8 hides six pixels to its left, whose guesses rise towards it. The first
  // of them is not covered by what the map says.
  EXPECT_EQ(FillHiddenPixels(RowOf({2, 2, 2, 2, 2, 2, 3, 3, 4, 5, 6, 6, 8, 8, 8, 8, 8, 2, 2, 2})),
            RowOf({2, 2, 2, 2, 2, 2, 3, 3, 3, 3, 3, 3, 8, 8, 8, 8, 8, 2, 2, 2}));
  // A slope is not hidden by itself.
  const ImageF slope = RowOf({0, 0.5f, 1, 1.5f, 2, 2.5f, 3, 3.5f, 4, 4.5f});
  EXPECT_EQ(FillHiddenPixels(slope), slope);
}

TEST(HiddenPixels, LieToTheLeftOfTheRightViewToo) {
  EXPECT_EQ(FillHiddenPixels(RowOf({9, 9, 9, 3, 3, 3, 3, 3})), RowOf({3, 3, 3, 3, 3, 3, 3, 3}));
  const ImageF outside = RowOf({5, 5, 5});
  EXPECT_EQ(FillHiddenPixels(outside), outside);
}

}  // namespace
}  // namespace parallax
