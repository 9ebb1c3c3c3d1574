// Keeps the views of a scene's rigs free while objects are added. Rigs are chosen on the layout, so
// that all variants of a seed share them, and floating objects make way for them.
#pragma once

#include <functional>
#include <vector>

#include "common/math/types.h"
#include "parallax/v1/config.pb.h"
#include "parallax/v1/scene.pb.h"
#include "worker/scene/floating/place_floating.h"

namespace parallax {

// The pose of an object at the time of a rig (Rig.time_s).
using PoseInTime = std::function<Pose(double time_s)>;

// Tests oriented boxes, so it errs on the side of free views. Not thread-safe.
class ViewGuard {
 public:
  ViewGuard(const v1::RigConfig& config, const v1::Scene& scene);

  // Returns whether an object with these bounds (object frame) may have these poses: not within
  // arm's reach of any rig's eyes, and neither it nor all objects taken so far fill too much of a
  // view, above all at short range.
  bool Allows(const Box3f& bounds, const PoseInTime& pose_at);
  // Keeps the last allowed object.
  void Take();

  // Returns the views, one for each left eye.
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
