// A scene whose objects move (SceneObject.motion), brought to the time of a frame.
#pragma once

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <vector>

#include "parallax/v1/scene.pb.h"
#include "worker/render/scene/render_scene.h"

namespace parallax {

// Returns for each mesh whether it moves within the scene's frames or from keyframe to keyframe;
// empty if none does.
std::vector<bool> MoversOf(const v1::Scene& scene, const SceneGeometry& geometry);

class MovingScene {
 public:
  // `geometry` is placed as at time 0 and must outlive the object. Scenes without motion are not
  // changed.
  MovingScene(const v1::Scene& scene, RenderScene* geometry);

  bool moves() const { return !objects_.empty(); }
  // Places everything as at that time. Errors: those of RenderScene::Move.
  absl::Status MoveTo(double time_s);
  // Returns for each moving object, by SceneObject.index, the world transform that takes its points
  // from one time to another.
  std::map<uint32_t, Eigen::Affine3d> MotionBetween(double now_s, double then_s) const;

 private:
  RenderScene& geometry_;
  std::vector<v1::SceneObject> objects_;  // None unless some move.
  std::optional<double> time_s_ = 0;      // At which they stand; nothing: a move failed.
};

}  // namespace parallax
