// Meshes of doors, windows and passages. Private to worker/layout.
#pragma once

#include <string>

#include "parallax/v1/scene.pb.h"
#include "worker/geometry/mesh.h"

namespace parallax {

// A leaf with panels, lining, casings on both faces, lever handles. Some doors are ajar, always
// outwards. Passages have no leaf.
Mesh MakeDoor(const v1::Room& room, const v1::Opening& opening);
// The leaf's class in the catalogue: "PanelDoor", "GlassPanelDoor"...
std::string LeafClassOf(const v1::Opening& opening);
// Whether curtains or a blind hang before it; they reach kDressing_m beyond the opening.
bool IsDressed(const v1::Opening& opening);
inline constexpr double kDressing_m = 0.2;
// A frame with mullions, sill board and handle; panes when the room has window glass. Some windows
// have curtains, blinds or shutters.
Mesh MakeWindow(const v1::Room& room, const v1::Opening& opening);

}  // namespace parallax
