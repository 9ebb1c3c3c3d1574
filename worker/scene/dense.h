// Dense floating objects before an open sky: objects, meshes and materials are made once for the
// scene; each rig is a keyframe with its own placement, lights, sky and baseline (v1::Keyframe).
#pragma once

#include "common/base/cancel.h"
#include "common/base/ids.h"
#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// Deterministic in (config without render and filters; seed). Keyframe k draws from addresses of
// its own, so more rigs only add keyframes. The scene's own poses, lights and sky are keyframe 0's.
// Errors: kCancelled; kInvalidArgument for unknown classes or materials.
absl::StatusOr<v1::Scene> SolveDense(const v1::SceneConfig& config, SceneSeed seed,
                                     const CancelToken& cancel);

}  // namespace parallax
