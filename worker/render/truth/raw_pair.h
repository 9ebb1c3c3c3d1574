// Correspondence of an unrectified pair: where the other camera sees each pixel's first hit. Exact
// first hits at pixel centres, independent of sampling and denoising.
#pragma once

#include "worker/render/camera/camera.h"
#include "worker/render/camera/stereo_frame.h"
#include "worker/render/scene/render_scene.h"

namespace parallax {

// Fills flow and occlusion of both views. `raw` has a lens in each eye (StereoCamera::RawFromRig).
//
// A pixel is visible (0) when its point lies within the other picture and one of the four pixels
// around it there, or their interpolation where all are surfaces, has a distance within 1 % of the
// point's; else it is occluded (255). Where there is no surface the flow is that of a point at
// infinity, visible when the other picture shows no surface there. Points that the other lens does
// not see have no flow and are occluded, and so are pixels to which no direction leads.
// Errors: kCancelled.
absl::Status TraceCorrespondence(const RenderScene& scene, const StereoCamera& raw,
                                 const CancelToken& cancel, RawView* left, RawView* right);

// Blackens the pixels to which no direction leads (LensRays::Sees).
void BlackenUnseen(const LensRays& lens, ImageF3* radiance);

}  // namespace parallax
