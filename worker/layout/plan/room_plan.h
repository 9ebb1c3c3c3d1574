// Draws one empty room: kind, size, trim, pillars; and openings along stretches of its walls.
// Private to worker/layout.
#pragma once

#include <vector>

#include "common/base/ids.h"
#include "common/base/rng.h"
#include "common/base/status.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {

// A part of a wall, measured as Opening.center_m.
struct WallStretch {
  int wall = 0;
  double low_m = 0, high_m = 0;
};

// Returns the main room without openings. Deterministic in (config, seed).
// Errors: kInvalidArgument for an unknown kind or a room too small to stand in.
absl::StatusOr<v1::Room> DrawMainRoom(const v1::RoomConfig& config, SceneSeed seed);

// Returns the whole length of all four walls.
std::vector<WallStretch> WholeWalls(const v1::Room& room);

// Where on a stretch an opening goes.
struct OpeningOdds {
  double near_corner_p = 0;    // Probability of an end of the stretch rather than its middle.
  double corner_gap_m = 0.25;  // Least masonry between an opening and the end of its stretch.
};

// Adds the opening on one of the stretches, clear of the others. Returns false, adding nothing, if
// none has room.
bool AddOpening(v1::Room& room, v1::Opening opening, const std::vector<WallStretch>& stretches,
                const OpeningOdds& odds, Rng& rng);

v1::Opening DrawDoor(const v1::Room& room, Rng& rng);
// Bathrooms get small windows high up.
v1::Opening DrawWindow(const v1::Room& room, Rng& rng);

// The bays of a hall: a lamp hangs in the middle of each, columns stand where four meet.
struct HallBays {
  int along_x = 1, along_y = 1;
  static HallBays Of(const v1::Room& room);
};

// Posts of large rooms: against a wall or standing free, clear of the openings. Halls have columns
// between their bays.
void AddPillars(v1::Room& room, Rng rng);

}  // namespace parallax
