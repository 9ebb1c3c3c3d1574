// Rigs for scenes whose things are placed anew in the view of each rig. Private to worker/scene.
#pragma once

#include "common/base/rng.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// The random stream of keyframe `index`, below the scene's `root`.
inline Rng KeyframeStream(const Rng& root, uint32_t index) { return root.Child("keyframe", index); }

// Adds config.count rigs, one a keyframe: each at the origin, looking anywhere around. Rig k draws
// from KeyframeStream(root, k), so that more rigs only add rigs.
void KeyframeRigs(const v1::RigConfig& config, const Rng& root, v1::Scene& recipe);

}  // namespace parallax
