// Parts that many pieces of furniture share: legs, knobs, handles, drawer and door fronts, and
// their usual slots.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/base/rng.h"
#include "worker/assets/kernel/builder.h"
#include "worker/assets/kernel/primitives.h"
#include "worker/assets/kernel/shape_noise.h"
#include "worker/assets/kernel/soft.h"
#include "worker/assets/kernel/sweep.h"

namespace parallax {

// Draw a float in [low, high), and one of the first `count` values of an enum.
inline float Draw(Rng& rng, double low, double high) {
  return static_cast<float>(rng.Uniform(low, high));
}
template <typename Enum>
Enum DrawEnum(Rng& rng, int count) {
  return static_cast<Enum>(rng.UniformInt(0, count - 1));
}

// Return slots with the material families that suit them.
MaterialSlot WoodSlot(const std::string& name);  // Furniture wood, painted now and then.
MaterialSlot MetalSlot(const std::string& name);
MaterialSlot FabricSlot(const std::string& name);  // Upholstery: fabric or leather.
MaterialSlot PlasticSlot(const std::string& name);
MaterialSlot CeramicSlot(const std::string& name);
MaterialSlot GlassSlot(const std::string& name);
MaterialSlot PictureSlot(const std::string& name = "picture");

// Joins meshes, as they are placed, into an asset whose base is on the ground. Empty meshes add
// nothing. `seed` varies texture offsets.
Asset FinishMeshes(const std::vector<const Mesh*>& meshes, uint64_t seed);

// Returns a shape that was modelled along +z from the origin, moved and turned so that it runs from
// `from` towards `to`.
kernel::Shape AlongZ(const kernel::Shape& shape, const Vec3f& from, const Vec3f& to);

// Section and outline of furniture legs.
enum class LegStyle { kSquare, kTapered, kRound, kTurned, kCount };

// Returns a turned (lathe) leg with beads, swellings and a foot, along +z from 0 to `height`.
// `variant` picks the pattern.
kernel::Shape TurnedLeg(float height, float radius, int variant);

// Returns a straight furniture leg from the floor point `foot` to `top`; `thickness` is its width
// at the top. All lengths in this header are metres.
kernel::Shape FurnitureLeg(LegStyle style, const Vec3f& foot, const Vec3f& top, float thickness,
                           int variant);

// Forms of handles on doors and drawers.
enum class HandleStyle { kKnob, kBar, kBow, kCup, kNone, kCount };

// Returns a handle on a front that lies in the plane y = 0 facing +y, centred on the origin; bars
// lie along x.
kernel::Shape Handle(HandleStyle style, float size);

// Relief of door and drawer fronts.
enum class FrontStyle { kFlat, kShaker, kRaised, kCount };

// Returns a door or drawer front facing +y: x in [-w/2, w/2], z in [0, h], back at y = 0,
// `thickness` thick.
kernel::Shape Front(FrontStyle style, float width, float height, float thickness, bool grain_up);

// Returns a rail bowed in plan: from -half to +half along x, its middle `bow` further along -y,
// upright section.
kernel::Shape BowedRail(float half, float bow, float thickness, float height, float z, float y,
                        float lean_rad);

}  // namespace parallax
