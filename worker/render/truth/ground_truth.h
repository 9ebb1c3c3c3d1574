// Ground truth of one eye: exact first hits at pixel centres, independent of sampling and
// denoising.
//
// Depth is the intersection, in double precision, of the pixel's line with the plane of the
// triangle that Embree found. Points of opacity below 0.5 are holes. Depth, disparity, normals,
// objects, materials and masks are set here; occlusion needs both eyes (MarkOcclusion).
#pragma once

#include <span>

#include "worker/render/camera/camera.h"
#include "worker/render/camera/stereo_frame.h"
#include "worker/render/lights/haze.h"
#include "worker/render/scene/render_scene.h"

namespace parallax {

// Fills all maps of `view` except color and occlusion. The scene's surroundings decide which pixels
// are exterior. Errors: kCancelled.
absl::Status TraceGroundTruth(const RenderScene& scene, const PinholeCamera& camera,
                              double baseline_m, const CancelToken& cancel, View* view);

// Computes occlusion of both views by left-right reprojection. A pixel of depth z lands in the
// other view, in the same row, at x -/+ fx * baseline / z. It is visible (0) when it lands inside
// the image, and one of the two pixels whose centres surround the landing point, or their linear
// interpolation where both are surfaces, has a depth within 1 % of z; else it is occluded (255).
// Two neighbours are tested, because on slanted surfaces depth changes by more than 1 % from one
// pixel to the next. Sky lands at its own x and is visible when the other view shows sky there.
void MarkOcclusion(View* left, View* right);

// Sets kMaskVeiled where haze leaves less than a twentieth of a surface's light.
void MarkVeiled(const Haze& haze, const PinholeCamera& camera, View* view);

// A line of sight from an eye to a point.
struct Sight {
  Vec3d to = Vec3d::UnitZ();  // From the eye to the point, world; its direction for `infinite`.
  bool infinite = false;      // The point is at infinity: any surface hides it.
  bool hidden = false;        // Set by LookAt.
};

// Finds which of up to 8 sights from the camera's origin are hidden: the first surface on the way,
// holes left out, is nearer than the point by more than 1 %.
void LookAt(const RenderScene& scene, const PinholeCamera& camera, std::span<Sight> sights);

// Relative difference of depths up to which a pixel is visible.
inline constexpr float kOcclusionThreshold = 0.01f;

}  // namespace parallax
