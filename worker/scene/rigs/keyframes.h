// Rig strategy: one keyframe a rig, whose objects are placed anew. Private to worker/scene.
#pragma once

#include "common/base/rng.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// The random stream of keyframe `index`, below the scene's `root`.
inline Rng KeyframeStream(const Rng& root, uint32_t index) { return root.Child("keyframe", index); }

// Adds config.count rigs, one a keyframe, at the origin with random orientations. Rig k draws from
// KeyframeStream(root, k), so that more rigs only add rigs.
void KeyframeRigs(const v1::RigConfig& config, const Rng& root, v1::Scene& recipe);

}  // namespace parallax
