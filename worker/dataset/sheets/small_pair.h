// A pair that is rendered smaller than its study asks for, and its figures at the study's own
// resolution. Pure functions; thread-safe.
#pragma once

#include <vector>

#include "common/image/image.h"
#include "common/math/types.h"
#include "parallax/v1/scene.pb.h"
#include "worker/render/camera/stereo_frame.h"

namespace parallax {

// Limits of disparities that networks learn from: below the first, matching says nothing of depth;
// trainers leave out pixels beyond the second.
inline constexpr float kLeastUsefulDisparity_px = 1;
inline constexpr float kMostTrainedDisparity_px = 192;

// Returns `rig` with pictures of at most this size, the raw ones as well: the views and shapes stay
// what they are. A rig that is as small already is returned as it is.
v1::Rig SmallRig(const v1::Rig& rig, int most_width_px, int most_height_px);

// Figures of one view's disparities. Shares but the last are of the pixels that see a surface.
struct DisparityFigures {
  double min_px = 0, max_px = 0, mean_px = 0, median_px = 0;  // 0 without a surface.
  double share_below_1px = 0;
  double share_beyond_192px = 0;
  double share_no_surface = 0;  // Of all pixels.
};
// Computes them. `disparity_px`: 0 = no surface.
DisparityFigures FiguresOf(const ImageF& disparity_px);

// How far apart the rows are in which the eyes see the same point.
struct RowFigures {
  double raw_mean_px = 0, raw_max_px = 0;  // Before rectification.
  double rectified_max_px = 0;             // After rectification by the rig's raw cameras.
};
// Computes them in pixels of `rig`, which has raw cameras, from the left raw view that `small`, its
// SmallRig, has rendered. Only pixels count that both eyes see.
RowFigures RowsOf(const v1::Rig& rig, const v1::Rig& small, const RawView& left);

// Returns where a raw eye of `rig` (0 left, 1 right) sees the row `y_px` of its rectified picture:
// points in pixels of the raw picture, from left to right. Empty where its lens does not see the
// row.
std::vector<Vec2d> RowInRaw(const v1::Rig& rig, int eye, double y_px);

}  // namespace parallax
