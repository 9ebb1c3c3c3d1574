// Doorways that show the next room: wide passages of open plans, doors that stand wide open.
// Private to worker/layout.
#pragma once

#include "common/base/rng.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// Makes `door` between two rooms a wide passage or opens its leaf, as often as the config says.
void OpenUp(const v1::RoomConfig& config, const v1::Room& a, const v1::Room& b, Rng rng,
            v1::Opening& door);

}  // namespace parallax
