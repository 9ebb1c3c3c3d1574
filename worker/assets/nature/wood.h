// Bark-clad wood of a tree as meshes: the limbs of a skeleton with collars at forks, the trunk's
// flare, twigs.
#pragma once

#include "worker/assets/kernel/builder.h"
#include "worker/assets/nature/detail.h"
#include "worker/assets/nature/skeleton.h"

namespace parallax {

struct WoodStyle {
  PlantDetail detail = PlantDetail::kNear;
  float flare = 1;        // How far the roots spread the foot, in the trunk's radii.
  bool has_trunk = true;  // The skeleton's first limb is one; false: a shrub's stems are all alike.
  float lumps = 0.06f;    // Height of the lumps of the surface, in radii of the trunk.
  MaterialSlot bark, twig_bark;
};

class WoodMaker {
 public:
  WoodMaker(const WoodStyle& style, Rng rng);

  // Each limb that the level of detail shows.
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
