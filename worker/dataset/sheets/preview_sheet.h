// The sheet of `parallax preview`: a pair of each variant of a study, a row each, with its figures.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/image/image.h"
#include "parallax/v1/scene.pb.h"
#include "worker/dataset/sheets/small_pair.h"

namespace parallax {

// The largest picture on the sheet, in pixels.
inline constexpr int kPreviewWidth_px = 320, kPreviewHeight_px = 240;

// The pair of a variant. Pictures are those of a SmallRig, all else is in pixels of the study's own
// resolution.
struct PreviewPair {
  v1::Rig rig;
  ImageRgb8 left, right;
  ImageF disparity_px;            // Of the left view; 0 = no surface.
  ImageRgb8 raw_left, raw_right;  // Empty without raw cameras.
  DisparityFigures disparities;
  RowFigures rows;  // With raw cameras.
};

struct PreviewRow {
  std::string name;
  std::shared_ptr<const PreviewPair> pair;  // Null: `note` says why none exists.
  std::string note;                         // May be empty.
};

struct PreviewText {
  std::string title;
  std::string below_title;
  std::string last_line;  // May be empty.
};

// The disparities of the first and the last colour.
struct DisparityScale {
  double low_px = 1, high_px = 1;
};
// Returns one scale for all rows, within the limits of training.
DisparityScale ScaleOf(const std::vector<PreviewRow>& rows);

// Draws the sheet. Raw pictures are below the rectified ones, with rows of these as coloured lines.
ImageRgb8 DrawPreviewSheet(const PreviewText& text, const std::vector<PreviewRow>& rows);

}  // namespace parallax
