// Rigs for places that a camera stands in: where depth spreads most. Private to worker/scene.
#pragma once

#include "parallax/v1/config.pb.h"
#include "worker/scene/dress.h"

namespace parallax {

// Adds stereo rigs with the largest spread of depth among random candidates. Each rig's height,
// pitch, field of view and baseline are drawn as the config says; only its place and direction are
// chosen, within the surroundings' bounds, above whose floor heights are drawn. Needs a committed
// solid twin. Adds fewer than config.count when there are not as many free places.
void BestSpreadRigs(const v1::RigConfig& config, SceneInProgress& scene);

}  // namespace parallax
