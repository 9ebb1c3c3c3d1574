// Rig strategy: ways of the rig through a room, as somebody carries it who looks about. Private to
// worker/scene.
#pragma once

#include "common/base/cancel.h"
#include "parallax/v1/config.pb.h"
#include "worker/scene/dress.h"

namespace parallax {

// Adds config.count rigs on config.path.paths ways, which share them evenly. Height, pitch, speed,
// camera and baseline are drawn once a way; where it leads is found on the layout, so that variants
// share it. Both eyes stay as far from everything as single rigs do, in frames and between them;
// from frame to frame the rig moves speed_mps / fps and turns at most max_turn_dps / fps. Needs a
// committed solid twin. Leaves fewer rigs, and says why, where a way is not found. Leaves fewer
// rigs, too, soon after it is cancelled.
void RoomPathRigs(const v1::RigConfig& config, const CancelToken& cancel, SceneInProgress& scene);

}  // namespace parallax
