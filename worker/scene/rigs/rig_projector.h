// The projectors of a scene's rigs, as lighting.projector says. Private to worker/scene.
#pragma once

#include "common/base/ids.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// Gives each rig of the recipe its projector, unless the power that is drawn is 0. All of a scene's
// rigs carry one device: numbers and pattern are drawn once, from addresses of their own; only
// where it stands follows the rig's baseline. Rigs that share a left eye share its place, too.
void AddProjectors(const v1::ProjectorConfig& config, SceneSeed seed, v1::Scene& recipe);

}  // namespace parallax
