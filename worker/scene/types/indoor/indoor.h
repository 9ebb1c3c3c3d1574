// Indoor scenes: houses of furnished rooms, seen from the first room.
#pragma once

#include "worker/scene/types/scene_types.h"

namespace parallax {

extern const SceneType kIndoorScenes;

}  // namespace parallax
