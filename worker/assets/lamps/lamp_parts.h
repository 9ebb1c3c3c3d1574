// Parts that lamps share: bulbs, shades, feet.
#pragma once

#include "worker/assets/parts.h"

namespace parallax {

// Forms of lamp shades.
enum class ShadeStyle { kDrum, kEmpire, kPleated, kDome, kGlobe, kCount };

// The slot for feet, poles and arms of lamps.
MaterialSlot LampBodySlot();

// A bulb with its socket, cap down at `at`, glass upwards, or turned over.
void AddBulb(kernel::AssetBuilder& b, const Vec3f& at, bool down, float size = 0.03f);

// The outside of a bulb's glass, radius and height, above its socket.
kernel::Path2 BulbGlass(float size);

// A shade turned from a closed section that goes up outside, in `outer_points` points, and down
// inside; the faces of its lining are group 1.
kernel::Shape LinedShade(const kernel::Path2& section, size_t outer_points, int segments);

// A shade open above and below: outside `shade`, lining a glowing "shade_inside". `at` is the
// middle of its lower edge; a spider of three wires carries it.
void AddShade(kernel::AssetBuilder& b, ShadeStyle style, float radius, float height,
              const Vec3f& at, bool spider = true);

// A closed circle about the z axis at height `z`, of `n` points.
kernel::Path3 Circle(float radius, float z, int n);

}  // namespace parallax
