// Assembles shapes into an Asset: slots by name, a texture offset for each part, support surfaces,
// origin. Not thread-safe.
#pragma once

#include <initializer_list>
#include <string>
#include <vector>

#include "worker/assets/asset.h"
#include "worker/assets/kernel/shape.h"

namespace parallax::kernel {

// The point that becomes the origin of a finished asset (see worker/assets/asset.h).
enum class Anchor {
  kFloor,    // Lowest point at z = 0, footprint's middle at x = y = 0.
  kWall,     // y >= 0 with the wall at y = 0; x centred; lowest point at z = 0.
  kCeiling,  // Highest point at z = 0, middle at x = y = 0.
  kGround,   // Lowest point at z = 0; x and y stay: the foot of a stem is the origin.
};

// Collects the parts of one asset.
class AssetBuilder {
 public:
  // `seed` decides only the parts' texture offsets.
  explicit AssetBuilder(uint64_t seed) : offsets_(SceneSeed{seed}, "texture") {}

  // Faces of group g get the g-th slot; the last slot serves all higher groups.
  void Add(const Shape& shape, std::initializer_list<MaterialSlot> slots);
  void Add(const Shape& shape, const MaterialSlot& slot) { Add(shape, {slot}); }
  // Adds the shape and its reflection at x = 0 (and, for four, at y = 0).
  void AddMirroredX(const Shape& shape, const MaterialSlot& slot);
  void AddFourfold(const Shape& shape, const MaterialSlot& slot);

  // Adds a finished mesh, placed (see Append).
  void AddMesh(const Mesh& mesh, const Eigen::Affine3f& place) { Append(asset_.mesh, mesh, place); }

  // Declares a horizontal rectangle that can carry things, in the parts' coordinates.
  void Support(const Vec2f& lo, const Vec2f& hi, float z_m, float clearance_m = 10.0f);

  const Mesh& mesh() const { return asset_.mesh; }

  // Moves everything to the anchor and returns the asset. Call once.
  Asset Finish(Anchor anchor = Anchor::kFloor);

 private:
  Rng offsets_;
  Asset asset_;
};

// Slots with the families that suit them, best first. Sheet slots hold open surfaces.
inline MaterialSlot Slot(std::string name, std::vector<std::string> families) {
  return {std::move(name), std::move(families), false};
}
inline MaterialSlot SheetSlot(std::string name, std::vector<std::string> families) {
  return {std::move(name), std::move(families), false, true};
}
inline MaterialSlot EmissiveSlot(std::string name) { return {std::move(name), {"emissive"}, true}; }

}  // namespace parallax::kernel
