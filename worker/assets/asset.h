// A procedural object: a mesh with named material slots, and the facts by which layouts place it.
//
// Object frame: z up, origin on the floor below the middle of the footprint; the front faces +y (a
// person who uses it stands at +y and looks along -y). Wall things (WallArt, Window, doors): the
// wall plane is y = 0, the thing at y >= 0. Things of the ground outdoors (trees, stones): the
// origin is the foot of the stem, or the middle of what has none, which need not be the middle of
// the bounding box; the lowest point is at z = 0.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/rng.h"
#include "worker/geometry/mesh.h"

namespace parallax {

// The place of a class in a room. kOpening: in a wall's opening; kGround: outdoors.
enum class Placement { kFloor, kFloorAgainstWall, kOnTop, kOnWall, kCeiling, kOpening, kGround };

// A horizontal rectangle that other things can stand on, object frame.
struct SupportSurface {
  Box2f area;              // x and y range, metres.
  float z_m = 0;           // Its height.
  float clearance_m = 10;  // Free height above it; small inside shelves.
};

// A generated object.
struct Asset {
  Mesh mesh;
  std::vector<SupportSurface> supports;
};

// The real sizes of a class: limits of the bounding box, metres.
struct SizeRange {
  SizeRange() = default;
  SizeRange(const Vec3f& least, const Vec3f& most) : least_m(least), most_m(most) {}
  Vec3f least_m = Vec3f::Zero(), most_m = Vec3f::Zero();
};

// One entry of the catalogue. `sample` draws the parameters from the stream and builds the mesh:
// the same stream gives the same bytes. Registered by worker/assets/<family>.cc.
struct AssetClass {
  std::string name;    // The paper's name: "ArmChair".
  std::string family;  // "seating", "tables", "storage"...
  Placement placement = Placement::kFloor;
  bool on_by_default = true;
  float front_clearance_m = 0;  // Free depth that a person needs in front of it.
  std::function<Asset(Rng&)> sample;
  SizeRange size;  // Bounds of what it makes; the suite holds every class to them.
};

// Every class in order of name; built once, thread-safe, lives for the program.
const std::vector<AssetClass>& AssetCatalogue();

// nullptr when there is no such class.
const AssetClass* FindAssetClass(std::string_view name);

// Makes the asset of a class and seed, as recipes name it.
// Errors: kNotFound naming the class and the nearest known name.
absl::StatusOr<Asset> MakeAsset(std::string_view class_name, uint64_t seed);

}  // namespace parallax
