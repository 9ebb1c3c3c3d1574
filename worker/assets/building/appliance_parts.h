// Parts that kitchen machines share: panels, cavities, shelves, knobs, handles, feet.
#pragma once

#include "worker/assets/parts.h"

namespace parallax {

MaterialSlot HousingSlot();  // Enamelled or of steel.
MaterialSlot TrimSlot();     // Handles, knobs, wires.
MaterialSlot DarkSlot();     // Insides, feet, and fronts behind glass.
MaterialSlot WindowSlot();

// A panel from y = `back` to `front`, facing +y, with a hole: four rounded bars. Corners are (x,
// z).
void AddHoledPanel(kernel::AssetBuilder& b, const Vec2f& lo, const Vec2f& hi, const Vec2f& hole_lo,
                   const Vec2f& hole_hi, float back, float front, const MaterialSlot& slot);

// A hollow box open towards +y.
void AddCavity(kernel::AssetBuilder& b, const Vec3f& lo, const Vec3f& hi, float wall,
               const MaterialSlot& slot);

// Rods from front to back and two across: an oven's or fridge's shelf, its top at z. Corners are
// (x, y).
void AddWireShelf(kernel::AssetBuilder& b, const Vec2f& lo, const Vec2f& hi, float z, int rods);

// A control knob on a front in the plane y = 0.
kernel::Shape Knob(float radius);

// A bar along x on two posts, which stand on the plane y = 0.
kernel::Shape BarHandle(float length, float stand_off, float radius);

// Round feet under the corners, their tops at z.
void AddFeet(kernel::AssetBuilder& b, float half_w, float half_d, float z);

}  // namespace parallax
