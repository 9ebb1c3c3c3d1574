// Meshes of what stands in a wall's openings. Private to worker/layout.
#pragma once

#include <string>

#include "parallax/v1/scene.pb.h"
#include "worker/geometry/mesh.h"

namespace parallax {

// Leaf with panels, lining, casings on both faces, lever handles. Some doors stand ajar, always
// outwards. Passages have no leaf.
Mesh MakeDoor(const v1::Room& room, const v1::Opening& opening);
// Which class of the catalogue the leaf is: "PanelDoor", "GlassPanelDoor"...
std::string LeafClassOf(const v1::Opening& opening);
// Frame with mullions, sill board, handle; panes when the room has window glass. Some have
// curtains, blinds or shutters.
// Whether curtains or a blind hang before it; they reach kDressing_m past the opening.
bool IsDressed(const v1::Opening& opening);
inline constexpr double kDressing_m = 0.2;
Mesh MakeWindow(const v1::Room& room, const v1::Opening& opening);

}  // namespace parallax
