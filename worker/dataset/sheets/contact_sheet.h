// Pictures of a dataset for people: a sheet with one frame a row, and a page of histograms.
#pragma once

#include <string>
#include <vector>

#include "common/base/status.h"

namespace parallax {

struct ContactSheetOptions {
  int max_frames = 8;       // Rows, spread evenly over the frames found.
  int tile_width_px = 360;  // Width of one image; the sheet has seven a row.
};

struct ContactSheetResult {
  std::string sheet_png;
  std::string histogram_png;  // Beside the sheet: "<name>_histograms.png".
  int frames = 0;             // Rows drawn.
  int frames_found = 0;
  // Median, over the rows, of the median absolute difference between the left image and the right
  // image warped by the left disparity, outside occlusions, in 8-bit steps. -1 without disparity
  // maps.
  double warp_median_difference = -1;
};

// Draws both pictures. `dir` is an archive, one of its variants, or any folder above frame folders
// (those with a frame.json). Errors: kNotFound if there is no frame below `dir`; those of reading
// frames and of writing.
absl::StatusOr<ContactSheetResult> MakeContactSheet(const std::string& dir,
                                                    const std::string& out_png,
                                                    const ContactSheetOptions& options = {});

// Returns the folders below `dir` with a frame.json, sorted. Does not follow symbolic links and
// skips folders whose names begin with a dot. Errors: those of opendir(3).
absl::StatusOr<std::vector<std::string>> FindFrames(const std::string& dir);

}  // namespace parallax
