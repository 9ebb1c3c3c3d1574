// Prints a recipe for people: ground plan, objects, materials, lights, rigs and the solver's
// report.
#pragma once

#include <map>

#include "coordinator/client/views/ground_plan.h"
#include "coordinator/client/views/terminal.h"
#include "parallax/v1/scene.pb.h"

namespace parallax::client {

// Bounds of an object in the world frame, in metres.
struct Extent {
  double x0 = 0, y0 = 0, z0 = 0, x1 = 0, y1 = 0, z1 = 0;
};

// Prints `scene`. `description` comes from the scene's type. `extents` maps SceneObject.index to
// bounds; objects without bounds are listed without a size and are not drawn.
void PrintScene(const Terminal& terminal, const v1::Scene& scene,
                const SceneDescription& description, const std::map<uint32_t, Extent>& extents);

}  // namespace parallax::client
