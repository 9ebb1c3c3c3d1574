// A recipe as text for people: ground plan, objects, materials, lights, rigs, and how the solver
// fared. Pure.
#pragma once

#include <map>

#include "coordinator/client/ground_plan.h"
#include "coordinator/client/terminal.h"
#include "parallax/v1/scene.pb.h"

namespace parallax::client {

// Extent of an object in the world, metres.
struct Extent {
  double x0 = 0, y0 = 0, z0 = 0, x1 = 0, y1 = 0, z1 = 0;
};

// `description` by the scene's type; `extents` by SceneObject.index: objects without one are listed
// without a size and not drawn.
void PrintScene(const Terminal& terminal, const v1::Scene& scene,
                const SceneDescription& description, const std::map<uint32_t, Extent>& extents);

}  // namespace parallax::client
