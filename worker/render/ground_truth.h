// Perfect ground truth of one eye: exact first hits at pixel centres, independent of sampling and
// denoising.
//
// Depth is the intersection, in double precision, of the pixel's line with the plane of the
// triangle that Embree found. Points of opacity below 0.5 are holes. Depth, disparity, normals,
// objects, materials and masks are set here; occlusion needs both eyes (MarkOcclusion).
#pragma once

#include <span>

#include "worker/render/camera.h"
#include "worker/render/haze.h"
#include "worker/render/render_scene.h"
#include "worker/render/stereo_frame.h"

namespace parallax {

// Fills all maps of `view` but color and occlusion. What is exterior the scene's surroundings say.
// Errors: kCancelled.
absl::Status TraceGroundTruth(const RenderScene& scene, const PinholeCamera& camera,
                              double baseline_m, const CancelToken& cancel, View* view);

// Occlusion of both views by left-right re-projection. A pixel of depth z lands in the other view,
// in the same row, at x -/+ fx * baseline / z. It is visible (0) when that is inside of the image,
// and one of the two pixels whose centres surround the landing point, or their linear interpolation
// where both are surfaces, has a depth within 1 % of z; else it is occluded (255). Two neighbours
// rather than the nearest pixel alone: on slanted surfaces depth changes by more than 1 % from one
// pixel to the next. Sky lands at its own x and is visible when the other view shows sky there.
void MarkOcclusion(View* left, View* right);

// Sets kMaskVeiled where haze leaves less than a twentieth of what is seen.
void MarkVeiled(const Haze& haze, const PinholeCamera& camera, View* view);

// Whether something stands before a point, as seen from an eye.
struct Sight {
  Vec3d to = Vec3d::UnitZ();  // From the eye to the point, world; else only where to look.
  bool infinite = false;      // The point is at infinity: any surface hides it.
  bool hidden = false;        // Set by LookAt.
};

// A row of up to 8 sights from the camera's origin. A point is hidden when the first surface on the
// way to it, holes left out, is nearer than it by more than 1 %.
void LookAt(const RenderScene& scene, const PinholeCamera& camera, std::span<Sight> sights);

inline constexpr float kOcclusionThreshold = 0.01f;

}  // namespace parallax
