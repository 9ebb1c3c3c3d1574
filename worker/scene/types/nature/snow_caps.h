// Snow that lies on things: rocks, branches, needles.
#pragma once

#include "worker/geometry/mesh.h"

namespace parallax {

// Adds caps to the faces of `mesh` that look up, in a slot "snow" and, on sheets, "snow sheets":
// `depth_m` thick where a face is level, running out to nothing where it is steep. Does nothing for
// a depth of 0.
void AddSnowCaps(float depth_m, Mesh& mesh);

}  // namespace parallax
