// Fills an irradiance volume with light that arrives at what the rigs of a scene see.
#pragma once

#include <vector>

#include "common/base/cancel.h"
#include "worker/render/camera/camera.h"
#include "worker/render/paths/irradiance_volume.h"
#include "worker/render/paths/path_tracer.h"

namespace parallax {

// The number of records that fill the volume, and its resolution.
struct VolumeFill {
  int64_t looks = 2'000'000;  // Total over all rigs; four records each. Time is proportional to it.
  float cell_m = 0.04f;       // Width of cells near the rigs.
  // Bounds the memory: at most 256 bytes a cell while filling, 128 bytes later.
  size_t max_cells = 1 << 20;
};

// Looks from both eyes of all rigs, in equal shares, at random points of their pictures, traces
// rays from there to all sides, and returns the volume of the light that they bring. The first
// round traces paths of up to 32 bounces; later ones end at their first rough surface in what
// earlier rounds have stored, so that light of many bounces is in it. Lamps and the sun's disc are
// left out where rays meet them first: they are sampled wherever the volume is read. The result
// depends only on the arguments, not on threads. Errors: kCancelled.
absl::StatusOr<IrradianceVolume> FillIrradianceVolume(
    const RenderScene& scene, const LightTable& lights, const PathOptions& options,
    uint64_t scene_seed, const std::vector<StereoCamera>& rigs, const VolumeFill& fill,
    const CancelToken& cancel);

}  // namespace parallax
