// Random changes that make one training pair into one crop. Every change keeps the pair a stereo
// pair: the left pixel (x, y) is the right pixel (x - disparity, y + y_offset).
//
// All draws come from streams named by the change, so what one change draws never shifts another's.
//   Source: RAFT-Stereo, core/utils/augmentor.py (colours, eraser, scale, stretch, y-jitter).
#pragma once

#include <vector>

#include "common/base/rng.h"
#include "worker/train/data/training_data.h"
#include "worker/train/network/settings.h"

namespace parallax {

// The network's input and target for one pair. Planes of height x width, rows from the top.
struct TrainingCrop {
  int height = 0, width = 0;
  std::vector<float> left, right;   // Three planes R, G, B in [0, 1].
  std::vector<float> disparity_px;  // Pixels of the crop.
  // Weight of the pixel's loss: 1 visible, less where occluded, 0 without truth.
  std::vector<float> weight;
};

// The placement of a crop in the pair, drawn by DrawGeometry.
struct CropGeometry {
  bool flip = false;          // Mirror both images and swap the eyes. Before everything else.
  int x = 0, y = 0;           // Corner of the window in the left image.
  int width = 0, height = 0;  // The window's size; it is resized to the crop's.
  int y_right = 0;            // Top of the window in the right image; it has the same columns.
};

// Draws the placement of a crop. Errors: kInvalidArgument if the pair is smaller than the crop,
// naming both sizes.
absl::StatusOr<CropGeometry> DrawGeometry(const TrainingPair& pair, const TrainSettings& settings,
                                          const Rng& rng);

// Returns the window resized to the crop, without changes of colour.
TrainingCrop CutCrop(const TrainingPair& pair, const CropGeometry& geometry,
                     const TrainSettings& settings);

// Changes colours, adds blur and noise, and erases rectangles of the right image, in place.
// Disparity and weight do not change.
void ChangeColours(TrainingCrop& crop, const AugmentSettings& settings, const Rng& rng);

// Draws a placement, cuts the crop and changes its colours: all of the above. Errors: those of
// DrawGeometry.
absl::StatusOr<TrainingCrop> Augment(const TrainingPair& pair, const TrainSettings& settings,
                                     const Rng& rng);

}  // namespace parallax
