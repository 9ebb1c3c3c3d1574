// Snow on top of objects: rocks, branches, needles.
#pragma once

#include "worker/geometry/mesh.h"

namespace parallax {

// Adds caps to the upward faces of `mesh`, in a slot "snow" and, for sheets, "snow sheets":
// `depth_m` thick where a face is level, thinning out to nothing where it is steep. Does nothing
// for a depth of 0.
void AddSnowCaps(float depth_m, Mesh& mesh);

}  // namespace parallax
