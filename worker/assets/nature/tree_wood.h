// Meshes of a tree's wood with bark: the limbs of a skeleton with collars at forks, the trunk's
// flare, twigs.
#pragma once

#include "worker/assets/kernel/builder.h"
#include "worker/assets/nature/plant_detail.h"
#include "worker/assets/nature/skeleton.h"

namespace parallax {

// The surface of the wood.
struct WoodStyle {
  PlantDetail detail = PlantDetail::kNear;
  float flare = 1;        // Spread of the roots at the foot, in the trunk's radii.
  bool has_trunk = true;  // The first limb is a trunk; false: a shrub.
  float lumps = 0.06f;    // Height of the lumps of the surface, in radii of the trunk.
  MaterialSlot bark, twig_bark;
};

// Builds the mesh of one plant's wood.
class WoodMaker {
 public:
  WoodMaker(const WoodStyle& style, Rng rng);

  // Adds the limbs that the level of detail shows.
  void AddTree(const Skeleton& tree);
  // The first ring is the foot.
  void AddTrunk(const std::vector<LimbRing>& rings);
  void AddBranch(const std::vector<LimbRing>& rings);
  // Tapers from `radius_m` to a third of it.
  void AddTwig(const std::vector<Vec3f>& path, float radius_m);

  void MoveTo(kernel::AssetBuilder& b) const;

 private:
  int SidesFor(float radius_m) const;
  float ThinnestShown() const;
  Vec3f Offset();

  WoodStyle style_;
  Rng rng_;
  Mesh bark_, twigs_;
};

}  // namespace parallax
