// Doorways that show the next room: wide passages of open plans, doors that stand wide open.
// Private to worker/layout.
#pragma once

#include "common/base/rng.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// Turns `door`, between the rooms `a` and `b`, into a wide passage or opens its leaf, with the
// probabilities of the config. Rooms of kinds that stay shut, such as bathrooms, get no passages.
void OpenUp(const v1::RoomConfig& config, const v1::Room& a, const v1::Room& b, Rng rng,
            v1::Opening& door);

}  // namespace parallax
