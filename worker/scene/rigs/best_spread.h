// Rig strategy: views with the largest spread of depth. Private to worker/scene.
#pragma once

#include "parallax/v1/config.pb.h"
#include "worker/scene/dress.h"

namespace parallax {

// Adds the stereo rigs with the largest spread of depth among random candidates. Each rig's height,
// pitch, field of view and baseline are drawn as the config says; only its place and direction are
// chosen, within the surroundings' bounds and above their floor. Requires a committed solid twin.
// Adds fewer than config.count if there are too few free places.
void BestSpreadRigs(const v1::RigConfig& config, SceneInProgress& scene);

}  // namespace parallax
