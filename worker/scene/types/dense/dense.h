// Dense scenes: many objects before an open sky. Objects, meshes and materials are made once for
// the scene; each rig is a keyframe with its own placement, lights, sky and baseline
// (v1::Keyframe). The scene's own poses, lights and sky are those of keyframe 0. Keyframe k draws
// from addresses of its own, so more rigs only add keyframes.
#pragma once

#include "worker/scene/types/scene_types.h"

namespace parallax {

extern const SceneType kDenseScenes;

}  // namespace parallax
