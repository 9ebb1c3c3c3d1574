// Keeps the views of a scene's rigs free while things are put into the scene: rigs are chosen on
// the layout, so that all variants of a seed share them, and what floats makes way for them.
#pragma once

#include <functional>
#include <vector>

#include "common/math/types.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/scene/place_floating.h"

namespace parallax {

// Where a thing stands when a rig looks, by Rig.time_s.
using PoseInTime = std::function<Pose(double time_s)>;

// Judges by oriented boxes, so errs on the side of the views. Not thread-safe.
class ViewGuard {
 public:
  ViewGuard(const v1::RigConfig& config, const v1::Scene& scene);

  // Whether a thing with these bounds (object frame) may stand or move there: not within arm's
  // reach of any rig's eyes, and neither it nor all the things taken so far fill much of a view,
  // above all from close by.
  bool Allows(const Box3f& bounds, const PoseInTime& pose_at);
  // The thing last allowed stays.
  void Take();

  // One for each left eye.
  const std::vector<RigView>& views() const { return views_; }

 private:
  struct Filled {
    double all = 0, near = 0;  // Parts of the image; overlaps count twice.
  };

  std::vector<RigView> views_;
  std::vector<Filled> taken_, asked_;
  double reach_m_ = 0;
  double clearance_m_ = 0;
};

}  // namespace parallax
