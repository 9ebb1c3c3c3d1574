// Meshes of doors, windows and passages. Private to worker/layout.
#pragma once

#include <string>

#include "parallax/v1/scene.pb.h"
#include "worker/geometry/mesh.h"

namespace parallax {

// Makes a door in the room's frame: a leaf with panels, lining, casings on both faces, lever
// handles. Some doors are ajar, always outwards. Passages have no leaf.
Mesh MakeDoor(const v1::Room& room, const v1::Opening& opening);
// Returns the leaf's class in the catalogue: "PanelDoor", "GlassPanelDoor"...
std::string LeafClassOf(const v1::Opening& opening);
// Returns whether curtains or a blind hang before the opening; they reach kDressing_m beyond it.
bool IsDressed(const v1::Opening& opening);
inline constexpr double kDressing_m = 0.2;
// Makes a window in the room's frame: a frame with mullions, sill board and handle, and panes if
// the room has window glass. Some windows have curtains, blinds or shutters.
Mesh MakeWindow(const v1::Room& room, const v1::Opening& opening);

}  // namespace parallax
