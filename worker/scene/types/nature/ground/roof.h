// The rock over a gorge that makes it a cave: a vault with holes for daylight, open at both ends. A
// closed body beside the ground's mesh; hanging objects ask for its underside.
//
// Constant after construction; thread-safe. The same recipe gives the same bits.
#pragma once

#include <optional>
#include <vector>

#include "parallax/v1/scene.pb.h"
#include "worker/geometry/mesh.h"
#include "worker/geometry/surroundings.h"
#include "worker/terrain/terrain.h"

namespace parallax {

// The vault of one recipe.
class CaveRoof {
 public:
  // Requires a recipe with a roof that has passed CheckRules. `cell_m` is the spacing of its
  // vertices.
  CaveRoof(const v1::Terrain& recipe, const Terrain& terrain, float cell_m);

  // Returns the vault's mesh in the world frame. Its texture coordinates are its positions; it has
  // one slot, "rock".
  const Mesh& mesh() const { return mesh_; }
  // Returns the height of the underside above `p`, world z; nothing under the open sky.
  std::optional<float> CeilingAt(const Vec2f& p) const;
  // Returns the height of the vault at `p` as if it had no holes.
  float VaultAt(const Vec2f& p) const { return Under(PlanOf(p)).z(); }

 private:
  // Converts to the roof's plan: along the gorge's axis and across its middle line.
  Vec2f PlanOf(const Vec2f& p) const;
  Vec2f PointOf(const Vec2f& plan) const;
  float FloorAt(float along_m) const;
  // Returns the distance from a point of the plan to the nearest hole's rim; < 0 in a hole.
  float FromSkylight(const Vec2f& p) const;
  Vec3f Under(const Vec2f& plan) const;
  Vec3f Top(const Vec2f& plan) const;
  void Build(float cell_m);
  void AddFaces(int columns, int rows, const std::vector<char>& open);

  const v1::CaveRoof roof_;
  const TerrainTerm gorge_;
  float half_m_, reach_m_;
  uint32_t seed_;
  std::vector<float> floors_;  // Heights of the gorge's floor, a metre apart along its axis.
  Mesh mesh_;
};

// Returns the space below a roof, with the openings through which light enters.
SkyEnclosure EnclosureUnder(const v1::Terrain& recipe, const Terrain& terrain);

}  // namespace parallax
