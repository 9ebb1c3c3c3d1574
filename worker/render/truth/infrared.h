// Infrared pictures of a rig: what its eyes' monochrome sensors see of the room's light and of the
// rig's projector.
//
// The room's light is that of the colour picture, denoised as it is. The projector's is added
// exactly: each pixel has a grid of samples, and each sample's surface gets the pattern's intensity
// over its footprint, by the inverse square of the distance, the surface's scattering and a shadow
// ray to the projector. So dots are as sharp as the pixels let them be and no denoiser sees them.
// Mirrors and glass are followed to what they show; holes and thin panes weaken light on its way
// from the projector; bodies of solid glass block it. Dots' light that is scattered twice is left
// out.
#pragma once

#include "common/base/cancel.h"
#include "worker/render/camera/camera.h"
#include "worker/render/camera/stereo_frame.h"
#include "worker/render/lights/projector.h"
#include "worker/render/scene/render_scene.h"
#include "worker/render/surface/sampler.h"

namespace parallax {

// Part of a room's light that reaches infrared sensors through their filters, as a projector's does
// wholly: lamps of today give little in the infrared.
inline constexpr float kAmbientInfrared = 0.15f;

// Returns a surface's or lamp's infrared level, from its colour: recipes know no spectra beyond
// red, and red is their next neighbour.
inline float InfraredOf(const Vec3f& rgb) { return Vec3f(0.6f, 0.3f, 0.1f).dot(rgb); }

// Returns the radiance, in W/(m^2 sr), that one eye sees of the projector's light; (height, width)
// of the camera, a pinhole. `origin`: where the projector stands, in the world; its axes are the
// camera's.
// Errors: kCancelled.
absl::StatusOr<ImageF> TraceProjector(const RenderScene& scene, const PinholeCamera& camera,
                                      const DotPattern& pattern, const Vec3d& origin,
                                      const SampleStream& stream, const CancelToken& cancel);

// Fills `infrared` of both views, which have their radiance, and the frame's exposure for them.
// `streams`: of the two eyes. `by_left`: exposes by the left picture alone, so that it is the same
// beside any right one. Errors: as TraceProjector and DotPattern::Make.
absl::Status RenderInfrared(const RenderScene& scene, const StereoCamera& stereo,
                            const v1::Rig& rig, const SampleStream streams[2], bool by_left,
                            const CancelToken& cancel, StereoFrame* frame);

}  // namespace parallax
