// Meshes of what stands in a wall's openings. Private to worker/layout.
#pragma once

#include "parallax/v1/scene.pb.h"
#include "worker/geometry/mesh.h"

namespace parallax {

// Leaf with panels, lining, casings on both faces, lever handles. A few doors stand ajar, always
// outwards.
Mesh MakeDoor(const v1::Room& room, const v1::Opening& opening);
// Frame with mullions, sill board, handle; panes when the room has window glass.
Mesh MakeWindow(const v1::Room& room, const v1::Opening& opening);

}  // namespace parallax
