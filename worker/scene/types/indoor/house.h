// A house's surroundings and description. Private to this folder, and to tests.
#pragma once

#include "parallax/v1/scene.pb.h"
#include "worker/geometry/surroundings.h"
#include "worker/scene/types/scene_types.h"

namespace parallax {

// Bounds are the first room; every room is an enclosure, with its windows, passages and doors for
// portals, and the open top where the ceiling is removed. Rooms without a size are left out. A
// landscape's ground reaches the horizon.
Surroundings HouseSurroundings(const v1::Place& place);

// Describes its rooms in words, with the first room's plan.
SceneDescription DescribeHouse(const v1::Scene& scene);

}  // namespace parallax
