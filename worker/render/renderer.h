// Renders the rigs of one scene. Geometry, acceleration structure, light tables and denoiser are
// made once and shared by them.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>

#include "common/base/cancel.h"
#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/geometry/scene_geometry.h"
#include "worker/render/camera/stereo_frame.h"

namespace parallax {

// Called from time to time with the fraction done, in [0, 1]; must be quick and thread-safe.
using ProgressFn = std::function<void(double)>;

// Constant after Create except for reused buffers: only one RenderRig may run at a time (it uses
// all cores itself).
class Renderer {
 public:
  // Builds everything that the rigs share. Copies or shares `scene` and `geometry`, so that they
  // need not outlive the renderer. At most `most_paths` paths fill what is stored of the light;
  // fewer than the profile's do for a picture of few pixels.
  // Errors: kResourceExhausted when memory does not suffice.
  static absl::StatusOr<std::unique_ptr<Renderer>> Create(const v1::Scene& scene,
                                                          SceneGeometry geometry,
                                                          const v1::RenderConfig& config,
                                                          int64_t most_paths = kAnyPaths);
  static constexpr int64_t kAnyPaths = std::numeric_limits<int64_t>::max();
  virtual ~Renderer() = default;

  // Renders both eyes of a rig with their ground truth. The noise of the eyes is independent.
  // Errors: kCancelled (within a second), kResourceExhausted.
  virtual absl::StatusOr<StereoFrame> RenderRig(const v1::Rig& rig, const CancelToken& cancel,
                                                const ProgressFn& progress) = 0;
};

}  // namespace parallax
