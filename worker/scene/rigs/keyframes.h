// Rig strategy: one keyframe a rig, whose objects are placed anew. Private to worker/scene.
#pragma once

#include "common/base/rng.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/scene/rigs/rig_camera.h"

namespace parallax {

// Returns the random stream of keyframe `index`, below the scene's `root`.
inline Rng KeyframeStream(const Rng& root, uint32_t index) { return root.Child("keyframe", index); }

// Adds the rig of keyframe `index` with this camera: its baseline and raw cameras are drawn from
// `keyframe`, which is KeyframeStream(root, index). `axes`: right, down, forward, world.
void AddKeyframeRig(const v1::RigConfig& config, const Rng& keyframe, uint32_t index,
                    const Vec3d& position, const Eigen::Matrix3d& axes, const RigCamera& camera,
                    v1::Scene& recipe);

// Adds config.count rigs, one a keyframe, at the origin with random orientations. Rig k draws from
// KeyframeStream(root, k), so that more rigs only add rigs.
void KeyframeRigs(const v1::RigConfig& config, const Rng& root, v1::Scene& recipe);

}  // namespace parallax
