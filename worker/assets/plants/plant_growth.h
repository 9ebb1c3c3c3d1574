// Growth of potted plants and bushes: leaves about stems, fronds, blades, spines, branches.
#pragma once

#include "worker/assets/parts.h"

namespace parallax {

// The slots for leaves and stems of potted plants.
MaterialSlot LeafSlot();
MaterialSlot StemSlot();

// The azimuth of the i-th leaf in a spiral by the golden angle.
inline float Golden(int i) { return 2.39996f * static_cast<float>(i); }

// Places a leaf that grows along +y at a point, turned to azimuth `a`, its base raised by `pitch`
// above the horizon. Angles are radians.
Eigen::Affine3f Growing(const Vec3f& at, float a, float pitch, float roll = 0);

// Grow from the soil at `base_z` about the z axis; `size` is the approximate height, `spread` the
// radius in which stems start.
void GrowBlades(kernel::AssetBuilder& b, float base_z, float size, float spread, Rng& rng);
void GrowRosette(kernel::AssetBuilder& b, float base_z, float size, Rng& rng);
void GrowBroad(kernel::AssetBuilder& b, float base_z, float size, float spread, bool lobed,
               Rng& rng);
void GrowFern(kernel::AssetBuilder& b, float base_z, float size, bool palm, Rng& rng);
void GrowSnake(kernel::AssetBuilder& b, float base_z, float size, float spread, Rng& rng);

// A ribbed column along `axis` (relative to `base`) with spines on its ribs.
struct CactusColumn {
  Vec3f base = Vec3f::Zero();
  kernel::Path3 axis;
  float radius_m = 0.1f;
  int ribs = 12;
  float spine_m = 0.02f;
};
// Grows a column with its spines.
void GrowCactus(kernel::AssetBuilder& b, const CactusColumn& column, Rng& rng);

// A woody trunk that forks and has leaves at its twigs. Call Branch, then Finish once.
struct TreeGrower {
  kernel::AssetBuilder& b;
  Rng& rng;
  float leaf_m;
  int depth;
  float leaf_width = 0.45f;
  int leaves_per_twig = 7;
  kernel::Shape wood{}, leaves{};

  void Branch(const Vec3f& from, const Vec3f& heading, float length, float radius, int level);
  void Finish();
};

}  // namespace parallax
