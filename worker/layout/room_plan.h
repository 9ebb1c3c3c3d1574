// Draws the empty room: kind, size, doors and windows. Private to worker/layout.
#pragma once

#include "common/base/ids.h"
#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// Deterministic in (config, seed). Openings that find no free stretch of wall are left out.
// Errors: kInvalidArgument for an unknown kind or a room too small to stand in.
absl::StatusOr<v1::Room> DrawRoom(const v1::RoomConfig& config, SceneSeed seed);

}  // namespace parallax
