// Streets of dense scenes: a ground that rigs look along, and objects of all sizes on both sides.
// Private to this folder.
#pragma once

#include <optional>
#include <vector>

#include "common/base/rng.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/geometry/mesh.h"
#include "worker/scene/floating/floating_choice.h"
#include "worker/scene/floating/place_floating.h"
#include "worker/scene/palettes.h"

namespace parallax {

// SceneObject.part of its ground.
inline constexpr char kStreetPart[] = "street";

v1::Street DrawStreet(const Rng& root);

// Makes carriageway, kerbs, walks, and the ground beside them out to the horizon, of closed boxes.
Mesh MakeStreet(const v1::Street& street);

// Materials of its slots: SceneMaterial.index.
uint32_t StreetMaterial(const MaterialSlot& slot, Palettes& palettes);

// Adds config.count rigs, one a keyframe: each on the carriageway, looking down the street one way
// or the other. Rig k draws from KeyframeStream(root, k).
void StreetRigs(const v1::RigConfig& config, const Rng& root, const v1::Street& street,
                v1::Scene& recipe);

// Puts things along a street before one rig.
class StreetPlacer {
 public:
  // All arguments must outlive the object.
  StreetPlacer(const v1::SceneConfig& config, const v1::Street& street, const RigView& view);

  // Returns a place for a thing with these bounds (object frame), its longest side `size_m`:
  // upright on the ground, or now and then turned in the air. Nothing where it would come near the
  // eyes.
  std::optional<Pose> Draft(Rng& rng, const Box3f& bounds, const FloatingSize& size) const;
  // Returns a pose behind everything, for an object that finds no place among the others. Different
  // numbers give different places.
  Pose FarAway(const Box3f& bounds, double size_m, size_t number) const;
  // Returns whether a lamp at `position` is above the ground.
  static bool Lights(const Vec3d& position) { return position.z() > 0.4; }

 private:
  bool ClearOfEyes(const Box3f& bounds, const Pose& pose) const;
  double GroundAt(double y) const;

  const v1::SceneConfig& config_;
  const v1::Street& street_;
  const RigView& view_;
  double ahead_ = 1;  // Along x: 1 or -1.
};

}  // namespace parallax
