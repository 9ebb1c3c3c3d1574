// A furnished room made without a solver: chairs, balls and boxes on a grid, materials of every
// family, a window, lamps.
#pragma once

#include "tests/worker/render/test_scenes.h"

namespace parallax::bench {

test::TestScene MakeDemoRoom(uint64_t seed);

}  // namespace parallax::bench
