// A picture of the differences within a study: the same pair of every variant, side by side.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"

namespace parallax {

struct VariantSheetOptions {
  int max_pairs = 3;        // One for each (scene, rig), spread evenly over the common ones.
  int tile_width_px = 420;  // Width of one left image.
  int columns = 5;
};

struct VariantSheetResult {
  std::string sheet_png;
  std::vector<std::string> variants;
  int pairs = 0;         // Blocks drawn.
  int pairs_common = 0;  // (scene, rig) that every variant has.
  // The disparity of the last colour in each block: 95 % of each variant's are at most this.
  std::vector<double> full_scale_px;
};

// Draws the sheet. `dir` is an archive with at least two variants. Errors: kNotFound if it is no
// archive; kFailedPrecondition with one variant only, or when no pair is common to all.
absl::StatusOr<VariantSheetResult> MakeVariantSheet(const std::string& dir,
                                                    const std::string& out_png,
                                                    const VariantSheetOptions& options = {});

}  // namespace parallax
